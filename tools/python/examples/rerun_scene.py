"""A recorded run in rerun, with what its reader of MCAP files does not draw: bodies as ellipsoids, the box, scalars.

It needs rerun-sdk; a second argument writes a file for the viewer instead of opening it:

    pip install "./tools/python" rerun-sdk==0.41.0
    python tools/python/examples/rerun_scene.py runs/quickstart
    python tools/python/examples/rerun_scene.py runs/quickstart quick.rrd
"""

import sys

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
import squirm

COLOURS = np.array([[230, 159, 0], [86, 180, 233], [0, 158, 115], [240, 228, 66], [213, 94, 0], [204, 121, 167]])

run = squirm.open_run(sys.argv[1] if len(sys.argv) > 1 else "runs/quickstart")
view = rr.RecordingStream("squirm")
if len(sys.argv) > 2:
    view.save(sys.argv[2])
else:
    view.spawn()

curves = [name for name in ("temperature", "swim_speed") if "scalars" in run.topics and name in run.scalars]
curve_views = rrb.Vertical(*(rrb.TimeSeriesView(origin=f"scalars/{name}", name=name) for name in curves))
space = rrb.Spatial3DView(contents=["box", "walls", "bodies", "headings"], name=run.name)
view.send_blueprint(rrb.Blueprint(rrb.Horizontal(space, curve_views, column_shares=[3, 1]) if curves else space))

half = run.box_size / 2
view.log("box", rr.Boxes3D(centers=[half], half_sizes=[half], colors=[128, 128, 128]), static=True)
if run.walls:
    # Thin slabs outside the fluid.
    centres = [[half[0], y, half[2]] for y in (-0.1, run.box_size[1] + 0.1)]
    slab = rr.Boxes3D(
        centers=centres, half_sizes=[[half[0], 0.1, half[2]]] * 2, colors=[128, 128, 128, 40], fill_mode="solid"
    )
    view.log("walls", slab, static=True)

for s in run.squirmers:
    view.set_time("time [tau]", duration=s.time)
    view.set_time("step", sequence=s.step)
    table = [(kind.across, kind.across, kind.along) for kind in s.species_table]
    colours = COLOURS[s.species % len(COLOURS)]
    # The body's z axis is the swimming axis, as the columns have it: sizes are semi-axes here.
    bodies = rr.Ellipsoids3D(
        centers=s.position,
        half_sizes=np.array(table)[s.species],
        quaternions=s.orientation,
        colors=colours,
        fill_mode="solid",
    )
    view.log("bodies", bodies)
    along = np.array([kind.along for kind in s.species_table])[s.species]
    view.log("headings", rr.Arrows3D(origins=s.position, vectors=1.5 * along[:, None] * s.axis))

for name in curves:
    for step, time, value in zip(run.scalars.step, run.scalars.time, run.scalars[name], strict=True):
        view.set_time("time [tau]", duration=time)
        view.set_time("step", sequence=step)
        view.log(f"scalars/{name}", rr.Scalars(value))
view.flush()
