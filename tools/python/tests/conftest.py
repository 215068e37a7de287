"""Runs of the real program for the tests: small boxes, few steps, on whatever adapter there is."""

import os
import signal
import subprocess
import tempfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]

# Two species, one of them wide, between two walls; blocks of 3 stick out of the box along x and y.
HEAD = """
[run]
seed = 3
steps = {steps}
dt = 0.05
[box]
size = [16, 8, 12]
walls = {{ axis = "y", condition = "no-slip" }}
[fluid]
density = 5
[[squirmers]]
name = "long"
count = 2
semi_axes = {{ along = 2.0, across = 1.5 }}
b1 = 0.05
[[squirmers]]
name = "flat"
count = 1
semi_axes = {{ along = 1.0, across = 1.5 }}
b1 = 0.05
beta = -1.0
"""
STAGES = [
    "squirmer-move", "stream", "squirmer-collide", "shift-grid", "cell-reduce", "wall-ghosts", "squirmer-fill",
    "rotate", "restore-thermostat",
]  # fmt: skip
RECORDED = """
[[output]]
record = ["squirmers", "scalars", "fields"]
csv = ["squirmers", "scalars"]
every = 4
block = 3
[[output]]
record = ["particles"]
every = 20
fraction = 1.0
"""
PUBLISHED = """
[[output]]
record = ["squirmers", "scalars", "fields"]
publish = ["squirmers", "scalars", "fields"]
every = 4
block = 3
"""


def program() -> Path:
    """The squirm that cargo has built."""
    path = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "squirm"
    assert path.is_file(), f"{path} is missing: cargo build --release"
    return path


def write_pipeline(folder: Path, name: str, steps: int, outputs: str) -> Path:
    """A pipeline file; runs are named after it."""
    path = folder / f"{name}.toml"
    stages = "".join(f'[[stage]]\nkind = "{kind}"\n' for kind in STAGES)
    path.write_text(HEAD.format(steps=steps) + stages + outputs)
    return path


def squirm(*arguments: object) -> str:
    """Calls the program; it must succeed."""
    done = subprocess.run([program(), *map(str, arguments)], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="session", autouse=True)
def _runtime_folder():
    """lavapipe complains without it."""
    if "XDG_RUNTIME_DIR" in os.environ:
        yield
        return
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_RUNTIME_DIR"] = folder
        yield
        del os.environ["XDG_RUNTIME_DIR"]


@pytest.fixture(scope="session")
def folder(tmp_path_factory) -> Path:
    """The folder of a finished run of 40 steps."""
    place = tmp_path_factory.mktemp("recorded")
    squirm("run", write_pipeline(place, "tiny", 40, RECORDED), "--out", place / "tiny", "--quiet")
    return place / "tiny"


class Going:
    """A run that would go on for hours, in a process of its own."""

    def __init__(self, place: Path, name: str) -> None:
        self.name, self.out = name, place / name
        pipeline = write_pipeline(place, name, 10_000_000, PUBLISHED)
        self.process = subprocess.Popen(
            [program(), "run", pipeline, "--out", self.out, "--quiet"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )

    def stop(self, how: signal.Signals = signal.SIGTERM) -> int:
        """Ends it; the exit status."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        self.process.communicate(timeout=120)
        return self.process.returncode


@pytest.fixture
def going(tmp_path):
    """A run that is going, under a name that nobody else uses."""
    run = Going(tmp_path, f"python-{os.getpid()}-{tmp_path.name}")
    yield run
    run.stop(signal.SIGKILL)
