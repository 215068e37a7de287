"""A recording of the real program against its own tables, value by value."""

import csv
import pickle
import re

import numpy as np
import pytest
import squirm
from conftest import ROOT
from conftest import squirm as program


@pytest.fixture(scope="module")
def run(folder):
    return squirm.open_run(folder)


def table(path):
    """Rows of a CSV file by their titles without units."""
    with path.open(newline="") as file:
        return [{key.split(" [")[0]: value for key, value in row.items()} for row in csv.DictReader(file)]


def numbers(row, names, kind=np.float32):
    return np.array([row[name] for name in names], dtype=kind)


def xyz(prefix):
    return [f"{prefix}{axis}" for axis in "xyz"]


def test_a_run_says_what_it_is(run, folder):
    assert (run.name, run.seed, run.walls) == ("tiny", 3, True)
    assert run.box_size.tolist() == [16, 8, 12]
    assert run.version == squirm.__version__
    assert re.fullmatch("[0-9a-f]{32}", run.run_id) and run.squirmers[0].run_id.hex() == run.run_id
    assert run.pipeline == (folder / "pipeline.toml").read_text()
    assert run.provenance["details"]["adapter"]
    assert run.topics == list(squirm.TOPICS)
    assert [path.name for path in run.paths] == ["run.mcap", "run.fluid.mcap"]
    assert run.warnings == []


def test_the_package_has_the_version_of_the_program():
    cargo = (ROOT / "Cargo.toml").read_text()
    project = (ROOT / "tools/python/pyproject.toml").read_text()
    version = f'version = "{squirm.__version__}"'
    assert version in cargo and version in project


def test_squirmers_are_those_of_the_tables(run, folder):
    rows = table(folder / "squirmers.csv")
    assert len(rows) == 3 * len(run.squirmers) == 33
    vectors = {
        "position": "",
        "axis": "e",
        "velocity": "v",
        "angular_velocity": "omega_",
        "force": "force_",
        "torque": "torque_",
    }
    for frame, snapshot in enumerate(run.squirmers):
        for i, row in enumerate(rows[3 * frame : 3 * frame + 3]):
            assert (snapshot.step, snapshot.time) == (int(row["step"]), float(row["time"]))
            assert snapshot.id[i] == int(row["id"])
            assert snapshot.species_table[snapshot.species[i]].name == row["species"]
            for column, prefix in vectors.items():
                assert np.array_equal(snapshot[column][i], numbers(row, xyz(prefix))), (column, frame)
            assert np.array_equal(snapshot.unwrapped[i], numbers(row, xyz("unwrapped_"), np.float64))


def test_squirmers_are_those_of_the_export(run, folder, tmp_path):
    for step in (0, 20, 40):
        out = tmp_path / str(step)
        program("export", folder, "--topic", "squirmers", "--at", step, "--out", out)
        snapshot = run.squirmers.at(step)
        rows = table(out / "squirmers.csv")
        assert len(rows) == snapshot.rows == 3
        for i, row in enumerate(rows):
            for column, prefix in (("position", ""), ("axis", "e"), ("velocity", "v")):
                assert np.array_equal(snapshot[column][i], numbers(row, xyz(prefix)))
            assert snapshot.id[i] == int(row["id"])


def test_scalars_are_those_of_the_export(run, folder, tmp_path):
    program("export", folder, "--topic", "scalars", "--out", tmp_path)
    rows = table(tmp_path / "scalars.csv")
    assert len(rows) == len(run.scalars.time) == 11
    assert list(rows[0]) == ["step", "time", *run.scalars.names]
    assert run.scalars.step.tolist() == [int(row["step"]) for row in rows]
    for name in run.scalars:
        assert run.scalars[name].tolist() == [float(row[name]) for row in rows], name
    assert run.scalars.unit("temperature") == "kT" and run.scalars.frames[0].unit("temperature") == "kT"
    assert run.scalars.frames[3].scalars["temperature"] == run.scalars["temperature"][3]


def test_particles_are_those_of_the_export_to_the_last_bit(run, folder, tmp_path):
    program("export", folder, "--topic", "particles", "--at", 20, "--out", tmp_path)
    rows = np.loadtxt(tmp_path / "particles.csv", delimiter=",", skiprows=1)
    snapshot = run.particles.at(20)
    assert snapshot.rows == snapshot.population == len(rows) > 1000
    assert np.array_equal(snapshot.position.astype(float) + snapshot.position_rest, rows[:, :3])
    assert np.array_equal(snapshot.velocity, rows[:, 3:].astype(np.float32))


def test_fields_are_averages_over_the_particles(run):
    for step in (0, 20, 40):
        fields, particles = run.fields.at(step), run.particles.at(step)
        assert fields.blocks == (6, 3, 4) and fields.block == 3
        assert fields.velocity.shape == (4, 3, 6, 3) and fields.density.shape == (4, 3, 6)
        x, y, z = ((particles.position.astype(float) + particles.position_rest) // 3).astype(int).T
        count, total = np.zeros((4, 3, 6)), np.zeros((4, 3, 6, 3))
        np.add.at(count, (z, y, x), 1)
        np.add.at(total, (z, y, x), particles.velocity)
        edges = [np.minimum(3, size - 3 * np.arange(n)) for size, n in zip((12, 8, 16), (4, 3, 6), strict=True)]
        volume = edges[0][:, None, None] * edges[1][None, :, None] * edges[2][None, None, :]
        assert np.array_equal(fields.density, (count / volume).astype(np.float32))
        # Some hundred numbers of size 1, each rounded to 2^-20 or better, and their sum to a f32.
        mean = np.divide(total, count[..., None], out=np.zeros_like(total), where=count[..., None] > 0)
        assert np.abs(fields.velocity - mean).max() < 1e-5


def test_nothing_is_copied_and_nothing_can_be_changed(run):
    for snapshot in (run.squirmers[1], run.fields[1], run.particles[1]):
        whole = np.frombuffer(snapshot.message, "u1")
        for name in snapshot.columns:
            column = snapshot[name]
            assert np.shares_memory(column, whole) and not column.flags.writeable
            with pytest.raises(ValueError):
                column[...] = 0
    with pytest.raises(AttributeError):
        snapshot.position = 1
    with pytest.raises(ValueError):
        run.scalars["temperature"][0] = 1


def test_columns_stack_over_time(run):
    unwrapped = run.array("squirmers", "unwrapped")
    assert unwrapped.shape == (11, 3, 3) and unwrapped.dtype == np.float64
    assert np.array_equal(unwrapped[5], run.squirmers[5].unwrapped)
    assert run.array("fields", "velocity").shape == (11, 4, 3, 6, 3)
    assert run.squirmers[2:4].array("axis").shape == (2, 3, 3)
    box = run.box_size
    assert np.allclose(np.mod(unwrapped, box), run.array("squirmers", "position"), atol=2e-6)


def test_frames_are_a_sequence(run):
    frames = run.squirmers
    assert frames.step.tolist() == list(range(0, 41, 4)) and frames.time.tolist() == [0.05 * s for s in range(0, 41, 4)]
    assert (frames[-1].step, frames[::5].step.tolist(), frames.lost) == (40, [0, 20, 40], 0)
    assert [s.seq for s in frames] == list(range(11))
    with pytest.raises(IndexError):
        frames[11]
    with pytest.raises(KeyError, match="from step 0 to 40"):
        frames.at(3)


def test_what_is_missing_is_named(run, tmp_path):
    with pytest.raises(squirm.NoSuchColumn, match="no `speed`; it has id, species, position"):
        _ = run.squirmers[0].speed
    with pytest.raises(KeyError):
        run.squirmers[0]["speed"]
    with pytest.raises(squirm.NoSuchTopic, match="there are squirmers, scalars"):
        run.frames("bodies")
    with pytest.raises(KeyError, match="temperature"):
        run.scalars["heat"]
    with pytest.raises(squirm.NoSuchRun, match="no recording"):
        squirm.open_run(tmp_path / "none")
    with pytest.raises(squirm.NoSuchRun, match="no recording"):
        squirm.open_run(tmp_path)
    (tmp_path / "run.mcap").write_bytes(b"something else")
    with pytest.raises(squirm.NotARecording, match="does not begin as an MCAP file"):
        squirm.open_run(tmp_path)


def test_files_can_be_named(folder):
    assert len(squirm.open_run(folder / "run.mcap").particles) == 3
    fluid = squirm.open_run(folder / "run.fluid.mcap")
    assert fluid.topics == ["particles"] and fluid.seed == 3
    with pytest.raises(squirm.NoSuchTopic, match="no snapshot of squirmers; it has particles"):
        _ = fluid.squirmers


def test_snapshots_survive_copies_and_pickles(run):
    snapshot = run.squirmers[4]
    for other in (snapshot.copy(), pickle.loads(pickle.dumps(snapshot))):
        assert other.message == snapshot.message and not np.shares_memory(other.axis, snapshot.axis)
    assert "at step 16" in repr(snapshot) and "position" in dir(snapshot)
