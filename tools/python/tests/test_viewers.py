"""What viewers get: every Foxglove message of a recording, decoded by other people's packages, against the numbers."""

import re
import subprocess
import sys
from collections import Counter

import numpy as np
import pytest
import squirm
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

SCHEMAS = {
    "/box": "foxglove.SceneUpdate",
    "/tf": "foxglove.FrameTransform",
    "/squirmers/poses": "foxglove.PosesInFrame",
    "/squirmers/scene": "foxglove.SceneUpdate",
    "/squirmers/points": "foxglove.PointCloud",
    "/fluid/slice": "foxglove.Grid",
    "/fluid/slab": "foxglove.VoxelGrid",
    "/fluid/points": "foxglove.PointCloud",
}
TYPES = {1: "u1", 3: "<u2", 5: "<u4", 7: "<f4", 8: "<f8"}


@pytest.fixture(scope="module")
def run(folder):
    return squirm.open_run(folder)


@pytest.fixture(scope="module")
def views(folder):
    """Decoded messages by topic and log time."""
    found = {}
    for name in ("run.mcap", "run.fluid.mcap"):
        with (folder / name).open("rb") as file:
            reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
            for schema, channel, message, decoded in reader.iter_decoded_messages(topics=list(SCHEMAS)):
                assert schema.name == SCHEMAS[channel.topic]
                assert message.log_time not in found.setdefault(channel.topic, {})
                found[channel.topic][message.log_time] = decoded
    return found


def at(views, topic, snapshot):
    """The message of a topic that belongs to a snapshot."""
    return views[topic][round(snapshot.time * 1e9)]


def xyz(vector):
    return np.array([vector.x, vector.y, vector.z])


def turned(quaternion, vector):
    """`vector` turned by a unit quaternion: v + 2 w (q x v) + 2 q x (q x v)."""
    q, w = xyz(quaternion), quaternion.w
    assert abs(q @ q + w * w - 1) < 1e-6
    cross = np.cross(q, vector)
    return np.asarray(vector) + 2 * w * cross + 2 * np.cross(q, cross)


def packed(message):
    """The fields of packed elements as one structured array."""
    stride = getattr(message, "point_stride", 0) or message.cell_stride
    fields = message.fields
    kinds = {"names": [f.name for f in fields], "formats": [TYPES[f.type] for f in fields]}
    return np.frombuffer(message.data, np.dtype(kinds | {"offsets": [f.offset for f in fields], "itemsize": stride}))


def test_every_topic_is_there_as_often_as_its_snapshots(run, views):
    counts = {topic: len(messages) for topic, messages in views.items()}
    assert counts == {topic: 3 if topic == "/fluid/points" else 11 for topic in SCHEMAS}
    assert list(views["/tf"]) == [round(t * 1e9) for t in run.squirmers.time]


def test_frames_and_times_fit_together(views):
    """Whatever is drawn is in the frame that /tf hangs into the world, at the time of its message."""

    def check(message, time):
        assert message.frame_id == "box"
        assert message.timestamp.ToNanoseconds() == time

    for topic, messages in views.items():
        for time, message in messages.items():
            if topic == "/tf":
                assert (message.parent_frame_id, message.child_frame_id) == ("world", "box")
                assert xyz(message.translation).tolist() == [0, 0, 0] and message.rotation.w == 1
                assert message.timestamp.ToNanoseconds() == time
            elif SCHEMAS[topic] == "foxglove.SceneUpdate":
                for entity in message.entities:
                    check(entity, time)
            else:
                check(message, time)


def test_spheroids_have_the_axes_and_headings_of_the_squirmers(run, views):
    for snapshot in run.squirmers:
        poses = at(views, "/squirmers/poses", snapshot).poses
        (bodies,) = at(views, "/squirmers/scene", snapshot).entities
        assert len(poses) == len(bodies.spheres) == len(bodies.arrows) == 3
        for i, (pose, sphere, arrow) in enumerate(zip(poses, bodies.spheres, bodies.arrows, strict=True)):
            species, axis = snapshot.species_table[snapshot.species[i]], snapshot.axis[i]
            # Sizes are full diameters along the axes of the pose; the body's z axis is the swimming axis.
            assert xyz(sphere.size).tolist() == [2 * species.across, 2 * species.across, 2 * species.along]
            assert np.allclose(turned(sphere.pose.orientation, [0, 0, 1]), axis, atol=1e-6)
            # Arrows point along x.
            assert np.allclose(turned(arrow.pose.orientation, [1, 0, 0]), axis, atol=1e-6)
            assert np.allclose(turned(pose.orientation, [1, 0, 0]), axis, atol=1e-6)
            # The arrow begins in the centre and must come out of the body.
            assert arrow.shaft_length + arrow.head_length > species.along
            for place in (pose.position, sphere.pose.position, arrow.pose.position):
                assert xyz(place).tolist() == snapshot.position[i].tolist()
    colours = [(s.color.r, s.color.g, s.color.b) for s in bodies.spheres]
    assert colours[0] == colours[1] != colours[2]


def test_points_are_the_squirmers(run, views):
    for snapshot in run.squirmers:
        points = packed(at(views, "/squirmers/points", snapshot))
        assert np.array_equal(np.stack([points[n] for n in "xyz"], axis=1), snapshot.position)
        assert np.array_equal(np.stack([points[n] for n in ("ux", "uy", "uz")], axis=1), snapshot.axis)
        assert points["red"][0] == points["red"][1] != points["red"][2]
        assert np.array_equal(points["id"], snapshot.id) and np.array_equal(points["species"], snapshot.species)


def test_points_of_the_fluid_are_its_particles(run, views):
    for snapshot in run.particles:
        points = packed(at(views, "/fluid/points", snapshot))
        assert np.array_equal(np.stack([points[n] for n in "xyz"], axis=1), snapshot.position)
        assert np.array_equal(np.stack([points[n] for n in ("vx", "vy", "vz")], axis=1), snapshot.velocity)


def test_the_box_has_its_edges_and_walls_where_the_fluid_ends(run, views):
    size = run.box_size
    for message in views["/box"].values():
        edges, walls = message.entities
        points = np.array([xyz(p) for p in edges.lines[0].points]).reshape(12, 2, 3)
        assert points.min() == 0 and points.max(axis=(0, 1)).tolist() == size.tolist()
        # Each edge runs along one axis, four along each.
        along = np.abs(points[:, 1] - points[:, 0])
        assert Counter(map(tuple, along.tolist())) == {tuple(row): 4 for row in np.diag(size).tolist()}
        low, high = walls.cubes
        assert xyz(low.pose.position)[1] + low.size.y / 2 == 0
        assert xyz(high.pose.position)[1] - high.size.y / 2 == size[1]
        assert (low.size.x, low.size.z) == (size[0], size[2])


def test_the_slice_is_the_middle_plane_of_the_fields(run, views):
    for snapshot in run.fields:
        nx, _, nz = snapshot.blocks
        grid, slab = at(views, "/fluid/slice", snapshot), at(views, "/fluid/slab", snapshot)
        cells = packed(grid).reshape(nz, nx)
        # y = 4 of 8 lies in the second block of 3.
        velocity, density = snapshot.velocity[:, 1], snapshot.density[:, 1]
        assert np.array_equal(np.stack([cells[n] for n in ("vx", "vy", "vz")], axis=-1), velocity)
        assert np.array_equal(cells["density"], density)
        assert np.allclose(cells["speed"], np.linalg.norm(velocity, axis=-1), rtol=1e-6)
        assert np.array_equal(cells["alpha"], np.where(density > 0, 255, 0))
        # White at rest, and the darkest blue from twice the root mean square on.
        fast = 2 * np.sqrt((density * cells["speed"] ** 2).sum(dtype=float) / density.sum(dtype=float))
        share = np.minimum(cells["speed"] / fast, 1)
        for colour, (slow, dark) in {"red": (247, 8), "green": (251, 48), "blue": (255, 107)}.items():
            assert np.abs(cells[colour] - (slow + share * (dark - slow))).max() <= 0.501
        # Corner, columns along x, rows along z.
        assert (grid.column_count, grid.row_stride, grid.cell_size.x, grid.cell_size.y) == (
            nx,
            nx * grid.cell_stride,
            3,
            3,
        )
        assert xyz(grid.pose.position).tolist() == [0, 4, 0]
        assert np.allclose(turned(grid.pose.orientation, [1, 0, 0]), [1, 0, 0])
        assert np.allclose(turned(grid.pose.orientation, [0, 1, 0]), [0, 0, 1])
        assert slab.data == grid.data and (slab.row_count, slab.column_count, slab.slice_stride) == (
            1,
            nx,
            grid.row_stride,
        )
        assert abs(slab.pose.position.y + slab.cell_size.y / 2 - 4) < 1e-12 and slab.pose.orientation.w == 1


RERUN = """
import sys
import rerun as rr
recording = rr.RecordingStream("squirm")
recording.save(sys.argv[1])
for path in sys.argv[2:]:
    rr.log_file_from_path(path, recording=recording)
recording.flush()
"""


def test_rerun_understands_the_same_files(folder, tmp_path):
    chunk = pytest.importorskip("rerun.chunk", reason="rerun-sdk has no wheel for this machine")
    out = tmp_path / "run.rrd"
    # In a process of its own: rerun completes its file when the process ends.
    files = [folder / "run.mcap", folder / "run.fluid.mcap"]
    subprocess.run([sys.executable, "-c", RERUN, out, *files], check=True, timeout=120)
    columns = set(re.findall("Column name: (.*)", str(chunk.RrdReader(out).store().schema())))
    wanted = {
        "/squirmers/points:Points3D:positions",
        "/squirmers/points:Points3D:colors",
        "/squirmers/poses:InstancePoses3D:quaternions",
        "/fluid/points:Points3D:positions",
        "/fluid/slab:VoxelGridMap:colors",
        "/tf:Transform3D:child_frame",
    }
    assert wanted <= columns, wanted - columns
