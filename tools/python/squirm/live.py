"""A run that is going, through shared memory (iceoryx2): snapshots as views of what the run has published."""

from __future__ import annotations

import ctypes
import os
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import LiveError, NoSuchRun, NoSuchTopic, TooManyHeld
from .snapshot import HEADER, TOPICS, Snapshot

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

#: How often a waiting reader looks for a publisher that was killed: nobody tells it otherwise.
_LOOK_FOR_DEAD = 1.0
#: Longest sleep in ms: after it, Python sees Ctrl-C.
_NAP = 100
#: Longest wait for the first snapshot when all topics are wanted, in s.
_FIRST = 2.0


class _Block(ctypes.Structure):
    """Element of a payload; the name fixes the layout across languages."""

    _fields_ = (("bytes", ctypes.c_uint8 * 16),)

    @staticmethod
    def type_name() -> str:
        return "squirm::Block"


class _Header(ctypes.Structure):
    """The header of a message once more, beside its payload."""

    _fields_ = (("words", ctypes.c_uint64 * (HEADER.size // 8)),)

    @staticmethod
    def type_name() -> str:
        return "squirm::SnapshotHeader"


def _iceoryx2() -> Any:
    try:
        import iceoryx2
    except ImportError as error:
        raise LiveError('live runs need the package iceoryx2 0.10: pip install "squirm[live]"') from error
    iceoryx2.set_log_level(iceoryx2.LogLevel.Error)
    return iceoryx2


def _config(iox2: Any) -> Any:
    """The shared-memory domain of this user, as src/wire/domain.rs has it."""
    config = iox2.config.default()
    uid = os.getuid() if hasattr(os, "getuid") else 0
    # Not tempfile.gettempdir(), which looks at more variables than the run does.
    root = Path(os.environ.get("TMPDIR") or ("/tmp" if os.name == "posix" else tempfile.gettempdir()))
    config.global_cfg.root_path = iox2.Path.new(str(root / f"iceoryx2-{uid}"))
    config.global_cfg.prefix = iox2.FileName.new(f"squirm{uid}_")
    return config


def live_runs() -> list[str]:
    """Names of the runs of this user that publish something now."""
    iox2 = _iceoryx2()
    names = {run for run, _ in _services(iox2, _config(iox2))}
    return sorted(names)


def _services(iox2: Any, config: Any) -> set[tuple[str, str]]:
    """Run and topic wherever both services of a topic are there, the one for snapshots and the one for events."""
    found: Counter[tuple[str, str]] = Counter()
    for service in iox2.Service.list(config, iox2.ServiceType.Ipc):
        parts = service.name().to_string().split("/")
        if len(parts) >= 3 and parts[0] == "squirm" and parts[-1] in TOPICS:
            found["/".join(parts[1:-1]), parts[-1]] += 1
    return {name for name, count in found.items() if count > 1}


def attach(run: str, topics: Iterable[str] | None = None, timeout: float = 0) -> Live:
    """Joins a run that is going on this machine, by its name (`squirm.live_runs()` lists them).

    `topics` defaults to all that the run publishes. The first snapshot of each is the newest one that the run has sent.
    Waits up to `timeout` seconds for a run that has not started yet.

    Raises NoSuchRun if no such run publishes here, NoSuchTopic if it does not publish one of the topics, LiveError if
    shared memory refuses.
    """
    begun = time.monotonic()
    topics = None if topics is None else list(topics)
    while True:
        try:
            return Live(run, topics)
        except (NoSuchRun, NoSuchTopic) as error:
            # A run that is just starting opens its topics one after another.
            patience = max(timeout, _FIRST) if isinstance(error, NoSuchTopic) else timeout
            if time.monotonic() - begun >= patience:
                raise
            time.sleep(_NAP / 1000)


class Live:
    """A run that is going; close it, or use it in a `with` statement."""

    def __init__(self, run: str, topics: Iterable[str] | None = None) -> None:
        #: Name of the run.
        self.run = run
        self._iox2 = _iceoryx2()
        config = _config(self._iox2)
        builder = self._iox2.NodeBuilder.new().config(config)
        builder = builder.signal_handling_mode(self._iox2.SignalHandlingMode.Disabled)
        domain = config.global_cfg.root_path.to_string()
        self._node = self._call(
            f"join the shared-memory domain {domain}", lambda: builder.create(self._iox2.ServiceType.Ipc)
        )
        self._looked = time.monotonic()
        self._topics: dict[str, LiveTopic] = {}
        absent = self._open(config, topics)
        if topics is None:
            # A run that is just starting has opened all of its topics when it sends its first snapshot.
            end = time.monotonic() + _FIRST
            while time.monotonic() < end and not any(topic.waiting for topic in self._topics.values()):
                time.sleep(0.01)
            self._open(config, None)
        # Services outlive their run while somebody else still reads them.
        if not self.going:
            raise NoSuchRun(absent)

    def _open(self, config: Any, topics: Iterable[str] | None) -> str:
        """Opens those of the topics that are not open yet; what to say if it turns out that the run has ended."""
        services = _services(self._iox2, config)
        published = [topic for topic in TOPICS if (self.run, topic) in services]
        names = ", ".join(sorted({name for name, _ in services if name != self.run}))
        absent = f"no run named `{self.run}` publishes here; {f'live: {names}' if names else 'no run is live'}"
        if not published:
            raise NoSuchRun(absent)
        for topic in published if topics is None else topics:
            if topic not in published:
                raise NoSuchTopic(
                    f"run `{self.run}` does not publish `{topic}`; it publishes {', '.join(published)}; "
                    f'a run publishes what an [[output]] asks it to: publish = ["squirmers"]'
                )
            if topic not in self._topics:
                self._topics[topic] = LiveTopic(self, topic)
        self._topics = {topic: self._topics[topic] for topic in TOPICS if topic in self._topics}
        return absent

    @property
    def topics(self) -> list[str]:
        """Topics that are read."""
        return list(self._topics)

    @property
    def squirmers(self) -> LiveTopic:
        """Snapshots of the squirmers."""
        return self.topic("squirmers")

    @property
    def scalars(self) -> LiveTopic:
        """Snapshots of named numbers; see :attr:`Snapshot.scalars`."""
        return self.topic("scalars")

    @property
    def fields(self) -> LiveTopic:
        """Snapshots of the fluid's density and velocity."""
        return self.topic("fields")

    @property
    def particles(self) -> LiveTopic:
        """Snapshots of a share of the fluid particles."""
        return self.topic("particles")

    def topic(self, name: str) -> LiveTopic:
        """Snapshots of one topic. Raises NoSuchTopic."""
        if name not in self._topics:
            raise NoSuchTopic(
                f"`{name}` is not read from run `{self.run}`; topics: {', '.join(self._topics) or 'none'}"
            )
        return self._topics[name]

    @property
    def going(self) -> bool:
        """Whether the run still publishes."""
        if self._node is not None and time.monotonic() - self._looked > _LOOK_FOR_DEAD:
            self._looked = time.monotonic()
            self._node.try_cleanup_dead_nodes()
        return any(topic.going for topic in self._topics.values())

    def close(self) -> None:
        """Leaves the run. Snapshots that are still held stay valid."""
        self._topics.clear()
        self._node = None

    def __iter__(self) -> Iterator[Snapshot]:
        """Snapshots of all topics as they come, until the run ends; those of one topic in order."""
        while self._topics:
            # Asked before the last snapshots are taken, so that none sent before the end is missed.
            going = self.going
            came = False
            for topic in list(self._topics.values()):
                # One of each in turn, so that a topic that comes often does not hide the others.
                snapshot = topic.next(timeout=0)
                if snapshot is not None:
                    came = True
                    yield snapshot
                # Given back before the next one is taken.
                del snapshot
            if not going and not came:
                return
            if not came:
                for topic in list(self._topics.values()):
                    topic.sleep(_NAP / 1000 / len(self._topics))

    def __enter__(self) -> Live:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<live run {self.run}: {', '.join(self._topics) or 'closed'}>"

    def _call(self, what: str, action: Any) -> Any:
        """Turns what iceoryx2 raises into an error of this package."""
        try:
            return action()
        except Exception as error:
            raise LiveError(f"cannot {what}: {type(error).__name__}: {error}") from error


class LiveTopic:
    """Snapshots of one topic as they come; iterating ends with the run.

    At most two snapshots of a topic can be held at a time, the last one included, since they are views of shared
    memory; keep :meth:`Snapshot.copy` of those that you want longer.
    """

    def __init__(self, live: Live, topic: str) -> None:
        self.topic = topic
        #: Snapshots that passed unseen between those received: the run sends faster than this program reads.
        self.lost = 0
        self._live = live
        self._expected: dict[int, int] = {}
        iox2, node, call = live._iox2, live._node, live._call
        name = iox2.ServiceName.new(f"squirm/{live.run}/{topic}")
        builder = node.service_builder(name).publish_subscribe(iox2.Slice[_Block]).user_header(_Header)
        what = "open the run's service (was it made by another version of squirm?)"
        self._service = call(what, builder.open)
        events = call("open the run's event service", node.service_builder(name).event().open)
        self._listener = call("open a listener", events.listener_builder().create)
        builder = self._service.subscriber_builder().history_request(1)
        self._subscriber = call("subscribe (do too many programs read this run?)", builder.create)

    @property
    def going(self) -> bool:
        """Whether the run still publishes this topic."""
        return bool(self._service.dynamic_config.number_of_publishers > 0)

    @property
    def waiting(self) -> bool:
        """Whether a snapshot has come that was not returned yet."""
        return bool(self._subscriber.has_samples())

    def next(self, timeout: float | None = None) -> Snapshot | None:
        """The next snapshot; waits for it, at most `timeout` seconds. None if none came, or the run has ended.

        Raises TooManyHeld if two snapshots of this topic are held, NotASnapshot for bytes that are none.
        """
        end = None if timeout is None else time.monotonic() + timeout
        while True:
            # Asked before the last snapshot is taken, so that none sent before the end is missed.
            going = self._live.going and self.going
            sample = self._receive()
            if sample is not None:
                return self._snapshot(sample)
            rest = _NAP / 1000 if end is None else min(end - time.monotonic(), _NAP / 1000)
            if not going or rest <= 0:
                return None
            self.sleep(rest)

    def latest(self, timeout: float | None = None) -> Snapshot | None:
        """The newest snapshot that has not been returned yet; waits as :meth:`next` does. Older ones count as lost."""
        newest = self.next(timeout)
        while newest is not None and self.waiting:
            # Given back first, so that it does not count among those held.
            newest = None
            self.lost += 1
            newest = self._snapshot(self._receive())
        return newest

    def sleep(self, seconds: float) -> None:
        """Waits until the run sends something, at most so long."""
        duration = self._live._iox2.Duration.from_millis(max(int(seconds * 1000), 1))
        try:
            self._live._call("wait for snapshots", lambda: self._listener.timed_wait(duration))
        except LiveError as error:
            # A program that was stopped (Ctrl-Z) and goes on is no failure.
            if "InterruptSignal" not in str(error):
                raise

    def __iter__(self) -> Iterator[Snapshot]:
        while True:
            snapshot = self.next()
            if snapshot is None:
                return
            yield snapshot
            del snapshot

    def __repr__(self) -> str:
        return f"<{self.topic} of live run {self._live.run}, {self.lost} lost>"

    def _receive(self) -> Any:
        try:
            return self._subscriber.receive()
        except Exception as error:
            if "ExceedsMaxBorrows" in f"{error!r}{error}":
                raise TooManyHeld(
                    f"two snapshots of {self.topic} are held: drop one before asking for the next, and keep "
                    "s.copy() or copies of arrays (s.position.copy()) instead of views"
                ) from error
            raise LiveError(f"cannot receive a snapshot: {type(error).__name__}: {error}") from error

    def _snapshot(self, sample: Any) -> Snapshot:
        payload = sample.payload()
        memory = (ctypes.c_uint8 * (16 * payload.len())).from_address(payload.as_ptr())
        # The sample goes back to the run when the last view of its memory is gone; the run may take back those of a
        # subscriber that has left, so it stays that long, too.
        memory._sample = sample, self._subscriber
        snapshot = Snapshot(memory)
        # Each distance between snapshots is an output of its own, with a numbering of its own.
        self.lost += max(snapshot.seq - self._expected.get(snapshot.every, snapshot.seq), 0)
        self._expected[snapshot.every] = snapshot.seq + 1
        return snapshot
