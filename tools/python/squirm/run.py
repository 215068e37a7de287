"""A recorded run: its files as one, its snapshots topic by topic."""

from __future__ import annotations

import glob
import json
import re
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from . import recording
from .errors import DamagedRecording, NoSuchRun, NoSuchTopic, RecordingWarning
from .snapshot import TOPICS, Snapshot

if TYPE_CHECKING:
    import os

    from numpy.typing import NDArray

    from .recording import Entry, Scan

#: The number of a later segment.
_LATER = re.compile(r"\.([0-9]{4,})$")


def open_run(path: str | os.PathLike[str]) -> Run:
    """Opens the recording of a run: its folder, its `run.mcap`, or another file of it.

    The folder and `run.mcap` stand for the whole run: all of its segments (`run.0001.mcap`, ...) in order, and the
    fluid particles beside them. Another first segment, such as `run.fluid.mcap`, stands for itself and the later ones;
    a later one stands for itself. Every checksum of the small topics is verified before this returns; that of the
    particles at their first use.

    Raises NoSuchRun, NotARecording or DamagedRecording; warns with RecordingWarning where a file ends in the middle.
    """
    place = Path(path)
    first = place / "run.mcap" if place.is_dir() else place
    small = _segments(first)
    fluid = _segments(first.with_name("run.fluid.mcap")) if first.name == "run.mcap" else []
    if not (place.is_dir() or place.is_file()) or not small + fluid:
        raise NoSuchRun(f"there is no recording {place}: name the folder of a run, or its run.mcap")
    return Run(small, fluid)


def _segments(first: Path) -> list[Path]:
    """The files of a recording in order, given its first segment; a later segment stands alone."""
    if _LATER.search(first.stem):
        return [first] if first.is_file() else []
    found = [(0, first)] if first.is_file() else []
    for path in first.parent.glob(f"{glob.escape(first.stem)}.*{first.suffix}"):
        number = _LATER.fullmatch(path.stem.removeprefix(first.stem))
        if number:
            found.append((int(number[1]), path))
    return [path for _, path in sorted(found)]


class Run:
    """A recorded run; see :func:`open_run`."""

    def __init__(self, small: list[Path], fluid: list[Path]) -> None:
        #: What its reader should know, also given as Python warnings.
        self.warnings: list[str] = []
        self._fluid = fluid
        self._scans = self._scan(small or fluid[:1])
        self._fluid_scans: list[Scan] | None = None
        self._frames: dict[str, Frames] = {}
        self._scalars: Scalars | None = None

    @property
    def name(self) -> str:
        """Name of the run; empty if the recording does not say."""
        return self._metadata("run")

    @property
    def run_id(self) -> str:
        """Identity of the run, hexadecimal."""
        return self._metadata("run_id")

    @property
    def seed(self) -> int:
        """Seed of the random numbers."""
        return int(self._metadata("seed") or 0)

    @property
    def version(self) -> str:
        """Version of the squirm that made it."""
        return self._metadata("version")

    @property
    def pipeline(self) -> str:
        """The pipeline file with every default filled in, as TOML."""
        return self._attachment("pipeline.toml")

    @property
    def provenance(self) -> dict[str, Any]:
        """What made the recording: adapter, driver, command line."""
        text = self._attachment("provenance.json")
        found: dict[str, Any] = json.loads(text) if text else {}
        return found

    @property
    def box_size(self) -> NDArray[np.float64]:
        """Edges of the box along x, y and z in a; NaN if nothing was recorded."""
        return np.array(next((s.box_size for s in self._all_scans() if s.box_size), (np.nan,) * 3))

    @property
    def walls(self) -> bool:
        """Whether there are walls at y = 0 and y = L; without them y is periodic, as x and z always are."""
        return next((s.walls for s in self._all_scans() if s.box_size), False)

    @property
    def paths(self) -> list[Path]:
        """The files, in order."""
        files = [scan.path for scan in self._scans]
        return files + [path for path in self._fluid if path not in files]

    @property
    def topics(self) -> list[str]:
        """Topics with at least one snapshot."""
        return [topic for topic in TOPICS if len(self._topic(topic)) > 0]

    @property
    def squirmers(self) -> Frames:
        """Snapshots of the squirmers."""
        return self._recorded("squirmers")

    @property
    def fields(self) -> Frames:
        """Snapshots of the fluid's density in m/a^3 and velocity in sqrt(kT/m), averaged over blocks of cells."""
        return self._recorded("fields")

    @property
    def particles(self) -> Frames:
        """Snapshots of the recorded share of the fluid particles."""
        return self._recorded("particles")

    @property
    def scalars(self) -> Scalars:
        """Named numbers over time."""
        if self._scalars is None:
            self._scalars = Scalars(self._recorded("scalars"))
        return self._scalars

    def frames(self, topic: str) -> Frames:
        """Snapshots of a topic: squirmers, scalars, fields or particles. Raises NoSuchTopic."""
        return self._recorded(topic)

    def array(self, topic: str, column: str) -> NDArray[Any]:
        """A column of all snapshots of a topic, stacked along a new first axis: a copy.

        Raises NoSuchTopic, NoSuchColumn, or ValueError if the snapshots have different shapes.
        """
        return self._recorded(topic).array(column)

    def __repr__(self) -> str:
        # Looking into the fluid's file would take long.
        known = [t for t in TOPICS if t != "particles" or not self._fluid or self._fluid_scans is not None]
        counts = [f"{len(self._topic(topic))} {topic}" for topic in known if len(self._topic(topic)) > 0]
        beside = [path.name for path in self._fluid if len(known) < len(TOPICS)]
        return f"<run {self.name or '?'}, seed {self.seed}: {', '.join(counts + beside) or 'no snapshots'}>"

    def _scan(self, paths: list[Path]) -> list[Scan]:
        scans = [recording.scan(path) for path in paths]
        # An earlier segment may lack its end, since the next one goes on; a gap between them shows in the numbering.
        if scans and scans[-1].truncated:
            last = scans[-1]
            why, count = "the run was killed or is still going", sum(map(len, last.entries.values()))
            self._warn(f"{last.path} ends in the middle: {why}; read {count} whole snapshots")
        ids = {s.metadata.get("run_id") for s in scans if s.metadata}
        if len(ids) > 1:
            raise DamagedRecording(f"{', '.join(str(s.path) for s in scans)} belong to different runs")
        return scans

    def _warn(self, text: str) -> None:
        self.warnings.append(text)
        warnings.warn(text, RecordingWarning, stacklevel=5)

    def _all_scans(self) -> list[Scan]:
        return self._scans + (self._fluid_scans or [])

    def _topic(self, topic: str) -> Frames:
        if topic not in TOPICS:
            raise NoSuchTopic(f"there is no topic `{topic}`; there are {', '.join(TOPICS)}")
        if topic not in self._frames:
            scans = self._scans
            if topic == "particles" and self._fluid:
                if self._fluid_scans is None:
                    known = {scan.path for scan in self._scans}
                    self._fluid_scans = self._scan([p for p in self._fluid if p not in known])
                scans = self._all_scans()
            frames = Frames(topic, _joined([scan.entries[topic] for scan in scans]))
            if len(scans) > 1 and frames.lost:
                self._warn(
                    f"{frames.lost} snapshots of {topic} are missing between the segments of {self.paths[0].parent}"
                )
            self._frames[topic] = frames
        return self._frames[topic]

    def _recorded(self, topic: str) -> Frames:
        frames = self._topic(topic)
        if len(frames) == 0:
            raise NoSuchTopic(
                f"{self.paths[0].parent} has no snapshot of {topic}; it has {', '.join(self.topics) or 'none at all'}; "
                f'a run records what an [[output]] asks it to: record = ["{topic}"]'
            )
        return frames

    def _metadata(self, key: str) -> str:
        return next((scan.metadata[key] for scan in self._scans if key in scan.metadata), "")

    def _attachment(self, name: str) -> str:
        return next((s.attachments[name].decode() for s in self._scans if name in s.attachments), "")


def _joined(segments: list[list[Entry]]) -> list[Entry]:
    """Snapshots of all segments; a later segment begins where the run was resumed, and counts from there on."""
    joined: list[Entry] = []
    for segment in segments:
        if segment:
            joined = [entry for entry in joined if entry.step < segment[0].step]
        joined += segment
    return joined


class Frames(Sequence[Snapshot]):
    """The recorded snapshots of one topic in the order of time; each is read when it is asked for."""

    def __init__(self, topic: str, entries: list[Entry]) -> None:
        self.topic = topic
        self._entries = entries
        self._cache = recording.Cache()

    @property
    def step(self) -> NDArray[np.int64]:
        """Steps of all snapshots."""
        return np.array([entry.step for entry in self._entries], dtype=np.int64)

    @property
    def time(self) -> NDArray[np.float64]:
        """Times of all snapshots in tau."""
        return np.array([entry.time for entry in self._entries], dtype=np.float64)

    @property
    def lost(self) -> int:
        """Snapshots that are missing between the first and the last, by their numbering."""
        return missing((entry.every, entry.seq) for entry in self._entries)

    def at(self, step: int) -> Snapshot:
        """The snapshot at this step. Raises KeyError if there is none."""
        for index, entry in enumerate(self._entries):
            if entry.step == step:
                return self[index]
        first, last = self._entries[0].step, self._entries[-1].step
        raise KeyError(f"no snapshot of {self.topic} at step {step}; there are {len(self)} from step {first} to {last}")

    def array(self, column: str) -> NDArray[Any]:
        """A column of all these snapshots, stacked along a new first axis: a copy; see :meth:`Run.array`."""
        out: NDArray[Any] | None = None
        for index, snapshot in enumerate(self):
            values = snapshot[column]
            if out is None:
                out = np.empty((len(self), *values.shape), values.dtype)
            if values.shape != out.shape[1:]:
                raise ValueError(
                    f"`{column}` has the shape {values.shape} at step {snapshot.step} and {out.shape[1:]} before: "
                    "such snapshots cannot be stacked; take them one by one"
                )
            out[index] = values
        if out is None:
            raise ValueError("no snapshot to stack")
        return out

    def __len__(self) -> int:
        return len(self._entries)

    @overload
    def __getitem__(self, index: int) -> Snapshot: ...
    @overload
    def __getitem__(self, index: slice) -> Frames: ...
    def __getitem__(self, index: int | slice) -> Snapshot | Frames:
        """One snapshot, or a range of them."""
        if isinstance(index, slice):
            return Frames(self.topic, self._entries[index])
        return recording.read(self._entries[index], self.topic, self._cache)

    def __iter__(self) -> Iterator[Snapshot]:
        return (self[index] for index in range(len(self)))

    def __repr__(self) -> str:
        if not self._entries:
            return f"<no snapshots of {self.topic}>"
        first, last = self._entries[0], self._entries[-1]
        times = f"t = {first.time:g} to {last.time:g} tau"
        return f"<{len(self)} snapshots of {self.topic}, steps {first.step} to {last.step}, {times}>"


class Scalars:
    """Named numbers over time: ``run.scalars["temperature"]`` is an array with one value for each of :attr:`time`."""

    def __init__(self, frames: Frames) -> None:
        #: The snapshots.
        self.frames = frames
        first = frames[0]
        #: Names in the order of the message.
        self.names: list[str] = list(first.scalars)
        self._units = {name: first.unit(name) for name in self.names}
        values = np.empty((len(self.names), len(frames)))
        for index, snapshot in enumerate(frames):
            scalars = snapshot.scalars
            if list(scalars) != self.names:
                raise DamagedRecording(f"the scalars changed during the run, at step {snapshot.step}")
            values[:, index] = snapshot["value"]
        values.flags.writeable = False
        self._values = dict(zip(self.names, values, strict=True))

    @property
    def step(self) -> NDArray[np.int64]:
        """Steps of the values."""
        return self.frames.step

    @property
    def time(self) -> NDArray[np.float64]:
        """Times of the values in tau."""
        return self.frames.time

    def unit(self, name: str) -> str:
        """Unit of a scalar; empty for pure numbers."""
        self[name]
        return self._units[name]

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        if name not in self._values:
            raise KeyError(f"there is no scalar `{name}`; there are {', '.join(self.names)}")
        return self._values[name]

    def __contains__(self, name: object) -> bool:
        return name in self._values

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def __repr__(self) -> str:
        units = (f"{name} [{unit}]" if unit else name for name, unit in self._units.items())
        return f"<{len(self.frames)} values each of {', '.join(units)}>"


def missing(numbers: Iterator[tuple[int, int]]) -> int:
    """Numbers that are skipped; each distance between snapshots is an output of its own and has its own numbering."""
    expected: dict[int, int] = {}
    lost = 0
    for every, seq in numbers:
        lost += max(seq - expected.get(every, seq), 0)
        expected[every] = seq + 1
    return lost
