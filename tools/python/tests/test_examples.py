"""The examples run as a user would start them."""

import json
import os
import re
import shutil
import subprocess
import sys

import pytest
from conftest import ROOT

EXAMPLES = ROOT / "tools/python/examples"


def run(*arguments, **variables):
    environment = os.environ | {"MPLBACKEND": "Agg"} | variables
    done = subprocess.run(
        [sys.executable, *map(str, arguments)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_trajectories_draws_its_pictures(folder, tmp_path):
    pytest.importorskip("matplotlib")
    copy = shutil.copytree(folder, tmp_path / "tiny")
    assert "wrote trajectories.png, flow.png and temperature.png" in run(EXAMPLES / "trajectories.py", copy)
    for name in ("trajectories.png", "flow.png", "temperature.png"):
        picture = (copy / name).read_bytes()
        assert picture.startswith(b"\x89PNG") and len(picture) > 5000


def test_the_notebook_runs_from_its_first_cell_to_its_last(folder, tmp_path):
    pytest.importorskip("matplotlib")
    notebook = json.loads((EXAMPLES / "explore.ipynb").read_text())
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert len(cells) > 3
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells), "outputs are not kept"
    script = tmp_path / "explore.py"
    script.write_text("\n".join("".join(cell["source"]) for cell in cells))
    assert " squirmers, " in run(script, SQUIRM_RUN_FOLDER=str(folder))


def test_rerun_gets_ellipsoids_headings_box_and_walls(folder, tmp_path):
    chunk = pytest.importorskip("rerun.chunk")
    out = tmp_path / "scene.rrd"
    run(EXAMPLES / "rerun_scene.py", folder, out)
    columns = set(re.findall("Column name: (.*)", str(chunk.RrdReader(out).store().schema())))
    wanted = {
        "/bodies:Ellipsoids3D:half_sizes",
        "/headings:Arrows3D:vectors",
        "/box:Boxes3D:half_sizes",
        "/walls:Boxes3D:half_sizes",
        "/scalars/temperature:Scalars:scalars",
    }
    assert wanted <= columns, wanted - columns
