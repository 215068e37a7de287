"""Runs that are going, seen from here and compared with what they record."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import squirm

PATIENCE = 120.0


def attached(going, topics=None):
    return squirm.attach(going.name, topics, timeout=PATIENCE)


def test_live_snapshots_are_those_of_the_recording(going):
    seen = {}
    with attached(going) as live:
        assert live.topics == ["squirmers", "scalars", "fields"] and going.name in squirm.live_runs()
        for snapshot in live:
            seen[snapshot.kind, snapshot.step] = bytes(snapshot.message)
            if len(seen) >= 24:
                break
        del snapshot
    assert going.stop() == 143
    run = squirm.open_run(going.out)
    for (kind, step), message in seen.items():
        assert bytes(run.frames(kind).at(step).message) == message, (kind, step)
    assert {kind for kind, _ in seen} == {"squirmers", "scalars", "fields"}


def test_two_programs_may_read_one_run_and_the_end_ends_both(going):
    with attached(going) as one, attached(going, ["squirmers"]) as two:
        first, second = one.squirmers.next(PATIENCE), two.squirmers.next(PATIENCE)
        assert first.run_id == second.run_id and two.topics == ["squirmers"]
        with pytest.raises(squirm.NoSuchTopic):
            _ = two.fields
        steps = [[first.step], [second.step]]
        del first, second
        for live, seen in zip((one, two), steps, strict=True):
            seen += [live.squirmers.next(PATIENCE).step for _ in range(3)]
        assert going.stop() == 143
        for live, seen in zip((one, two), steps, strict=True):
            seen += [s.step for s in live.squirmers]
            assert seen == sorted(set(seen)) and not live.going
    # What the run sent last reached both.
    last = squirm.open_run(going.out).squirmers[-1].step
    assert [seen[-1] for seen in steps] == [last] * 2
    with pytest.raises(squirm.NoSuchRun, match="no run named"):
        squirm.attach(going.name)


def test_a_killed_run_ends_too(going):
    with attached(going) as live:
        assert live.scalars.next(PATIENCE).scalars["temperature"] > 0
        going.stop(signal.SIGKILL)
        begun = time.monotonic()
        steps = [s.step for s in live.squirmers]
        assert steps and time.monotonic() - begun < PATIENCE
    with pytest.warns(squirm.RecordingWarning, match="ends in the middle"):
        run = squirm.open_run(going.out)
    assert run.squirmers.lost == 0


READS = """
import sys, squirm
with squirm.attach(sys.argv[1], ["scalars"], timeout=120) as live:
    for s in live.scalars:
        print(s.seq, flush=True)
"""


def test_a_reader_that_was_stopped_goes_on(going):
    reader = subprocess.Popen([sys.executable, "-c", READS, going.name], stdout=subprocess.PIPE, text=True)
    seen = [int(reader.stdout.readline())]
    for _ in range(3):
        reader.send_signal(signal.SIGSTOP)
        time.sleep(0.3)
        reader.send_signal(signal.SIGCONT)
        seen += [int(reader.stdout.readline()) for _ in range(5)]
    assert going.stop() == 143
    seen += map(int, reader.stdout)
    assert reader.wait(PATIENCE) == 0 and seen == sorted(set(seen))


def test_views_are_shared_memory_and_stay_as_they_are(going):
    with attached(going, ["squirmers"]) as live:
        first = live.squirmers.next(PATIENCE)
        second = live.squirmers.next(PATIENCE)
        assert not first.position.flags.writeable and second.seq == first.seq + 1
        with pytest.raises(squirm.TooManyHeld, match="copy"):
            live.squirmers.next(PATIENCE)
        kept, position = first.copy(), first.position
        assert np.shares_memory(position, np.frombuffer(first.message, "u1"))
        # The array alone holds the sample, although its snapshot is gone.
        del first
        with pytest.raises(squirm.TooManyHeld):
            live.squirmers.next(PATIENCE)
        del second
        for _ in range(12):
            third = live.squirmers.next(PATIENCE)
            assert third is not None and third.step > kept.step
            del third
        assert np.array_equal(position, kept.position)
    # Also after leaving the run, which goes on publishing, and after its end.
    time.sleep(0.5)
    assert np.array_equal(position, kept.position)
    assert going.stop() == 143
    assert np.array_equal(position, kept.position)


def test_a_reader_that_sleeps_counts_what_it_missed(going):
    with attached(going, ["squirmers", "scalars"]) as live:
        first = live.squirmers.next(PATIENCE).seq
        while live.scalars.latest(PATIENCE).seq < first + 12:
            pass
        received = [live.squirmers.next(PATIENCE).seq for _ in range(4)]
        assert live.squirmers.lost == received[-1] - first - len(received) > 0
        before = live.squirmers.lost
        while live.scalars.latest(PATIENCE).seq < received[-1] + 12:
            pass
        newest = live.squirmers.latest(PATIENCE).seq
        assert live.squirmers.lost - before == newest - received[-1] - 1 > 0


def test_what_is_not_there_is_named(going):
    with pytest.raises(squirm.NoSuchRun, match="no run named `nobody-has-this` publishes here"):
        squirm.attach("nobody-has-this")
    with attached(going):
        with pytest.raises(squirm.NoSuchRun, match=f"live: .*{going.name}"):
            squirm.attach("nobody-has-this")
        with pytest.raises(squirm.NoSuchTopic, match="does not publish `particles`; it publishes squirmers"):
            squirm.attach(going.name, ["particles"])


def test_another_temporary_folder_is_another_domain(going, tmp_path, monkeypatch):
    with attached(going):
        assert going.name in squirm.live_runs()
        monkeypatch.setitem(os.environ, "TMPDIR", str(tmp_path))
        assert going.name not in squirm.live_runs()
