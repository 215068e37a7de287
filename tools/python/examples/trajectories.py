"""Trajectories and the flow field of a recorded run, drawn with matplotlib.

Make a recording with many fields, then draw it:

    squirm run pipelines/quickstart.toml --set output.1.every=4
    python tools/python/examples/trajectories.py runs/quickstart

The `# %%` cells open as a notebook in Jupyter (jupytext), VS Code or Spyder. Pictures are written beside the recording.
"""

# %% Open the run: its folder, or one file of it
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import squirm

path = Path(sys.argv[1] if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "runs/quickstart")
folder = path if path.is_dir() else path.parent
run = squirm.open_run(path)
print(run)
print(run.squirmers, run.squirmers[0].species_table, sep="\n")

# %% Where the squirmers went: centres in a, followed through the periodic boundaries
squirmers = run.squirmers
centres = run.array("squirmers", "unwrapped")  # (snapshots, squirmers, 3)
axes = run.array("squirmers", "axis")
species = squirmers[0].species_table
length = run.box_size

figure, plot = plt.subplots(figsize=(6, 6), layout="constrained")
for i in range(centres.shape[1]):
    (line,) = plot.plot(centres[:, i, 0], centres[:, i, 2], lw=1)
    size = species[squirmers[0].species[i]].along
    here, heading = centres[-1, i, [0, 2]], size * axes[-1, i, [0, 2]]
    plot.plot(*centres[0, i, [0, 2]], "o", ms=4, color=line.get_color())
    plot.quiver(*here, *heading, color=line.get_color(), angles="xy", scale_units="xy", scale=1, width=0.004)
    plot.update_datalim([here + heading])
plot.plot(length[0] * np.array([0, 1, 1, 0, 0]), length[2] * np.array([0, 0, 1, 1, 0]), color="0.6", lw=1)
plot.autoscale_view()
plot.set(xlabel="x [a]", ylabel="z [a]", aspect="equal")
plot.set_title(
    f"{centres.shape[1]} squirmers, t = {squirmers.time[0]:g} to {squirmers.time[-1]:g} tau, seed {run.seed}"
)
figure.savefig(folder / "trajectories.png", dpi=120)

# %% The flow, seen from above: averaged over the second half of the run and across the box, weighted with the density
fields = run.fields[len(run.fields) // 2 :]
mass, momentum = 0.0, 0.0
for f in fields:  # (nz, ny, nx) and (nz, ny, nx, 3)
    mass = mass + f.density.sum(axis=1, dtype=float)
    momentum = momentum + (f.density[..., None] * f.velocity.astype(float)).sum(axis=1)
flow = momentum / np.where(mass > 0, mass, 1)[..., None]

edge = fields[0].block
x, z = (edge * (np.arange(n) + 0.5) for n in (flow.shape[1], flow.shape[0]))
speed = np.hypot(flow[..., 0], flow[..., 2])
figure, plot = plt.subplots(figsize=(7, 6), layout="constrained")
extent = (0, edge * len(x), 0, edge * len(z))
colours = plot.imshow(speed, origin="lower", extent=extent, cmap="Blues", interpolation="nearest")
plot.quiver(x, z, flow[..., 0], flow[..., 2], pivot="mid", width=0.003)
turn = np.linspace(0, 2 * np.pi, 60)
images = [(i * length[0], k * length[2]) for i in (-1, 0, 1) for k in (-1, 0, 1)]
for centre, e, kind in zip(squirmers[-1].position, axes[-1], squirmers[-1].species, strict=True):
    # The outline of a spheroid from above, at the end, with its periodic images.
    along, across = species[kind].along, species[kind].across
    flat = np.array([e[0], e[2]])
    tilt = np.linalg.norm(flat)
    flat = flat / tilt if tilt > 0 else np.array([1.0, 0.0])
    long = np.sqrt((along * tilt) ** 2 + across**2 * (1 - tilt**2))
    outline = np.outer(long * np.cos(turn), flat) + np.outer(across * np.sin(turn), [-flat[1], flat[0]])
    for image in images:
        place = centre[[0, 2]] + image
        plot.plot(*(outline + place).T, color="tab:orange", lw=1.5)
        plot.arrow(*place, *(along * e[[0, 2]]), color="tab:orange", head_width=0.6, length_includes_head=True)
plot.set(xlabel="x [a]", ylabel="z [a]", aspect="equal", xlim=(0, length[0]), ylim=(0, length[2]))
plot.set_title(f"flow averaged over t = {fields.time[0]:g} to {fields.time[-1]:g} tau")
figure.colorbar(colours, label=f"speed in the plane [{fields[0].unit('velocity')}]", shrink=0.8)
figure.savefig(folder / "flow.png", dpi=120)

# %% Temperature over time
figure, plot = plt.subplots(figsize=(6, 3), layout="constrained")
plot.plot(run.scalars.time, run.scalars["temperature"])
plot.set(xlabel="t [tau]", ylabel=f"temperature [{run.scalars.unit('temperature')}]")
figure.savefig(folder / "temperature.png", dpi=120)
print(f"wrote trajectories.png, flow.png and temperature.png into {folder}")
