"""Recordings and live runs of squirm as numpy arrays.

For example:

    run = squirm.open_run("runs/quickstart")
    for s in run.squirmers:
        print(s.step, s.time, s.position, s.axis)

Units: a (edge of a collision cell), m (mass of a fluid particle), kT, and tau = a sqrt(m/kT).
"""

from .errors import (
    DamagedRecording,
    LiveError,
    NoSuchColumn,
    NoSuchRun,
    NoSuchTopic,
    NotARecording,
    NotASnapshot,
    RecordingWarning,
    SquirmError,
    TooManyHeld,
)
from .live import Live, LiveTopic, attach, live_runs
from .run import Frames, Run, Scalars, open_run
from .snapshot import TOPICS, Snapshot, Species

__version__ = "0.1.0"

__all__ = [
    "TOPICS",
    "DamagedRecording",
    "Frames",
    "Live",
    "LiveError",
    "LiveTopic",
    "NoSuchColumn",
    "NoSuchRun",
    "NoSuchTopic",
    "NotARecording",
    "NotASnapshot",
    "RecordingWarning",
    "Run",
    "Scalars",
    "Snapshot",
    "Species",
    "SquirmError",
    "TooManyHeld",
    "attach",
    "live_runs",
    "open_run",
]
