"""Recordings that end in the middle, are damaged, or have several segments."""

import random
import struct
import warnings

import pytest
import squirm
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.writer import Writer


@pytest.fixture(scope="module")
def whole(folder):
    """The bytes of a finished file, and its snapshots by topic."""
    run = squirm.open_run(folder)
    return (folder / "run.mcap").read_bytes(), {
        topic: messages(run, topic) for topic in ("squirmers", "scalars", "fields")
    }


def messages(run, topic):
    frames = run.frames(topic) if topic in run.topics else []
    return [(s.step, bytes(s.message)) for s in frames]


def opened(path, data):
    """The run in a file with these bytes, and whether it was opened with a warning."""
    path.write_bytes(data)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = squirm.open_run(path)
    assert [str(w.message) for w in caught] == run.warnings
    return run


def test_a_file_that_ends_anywhere_gives_its_whole_chunks_and_a_warning(whole, tmp_path):
    data, expected = whole
    path = tmp_path / "run.mcap"
    most = 0
    for end in [*range(8, len(data), 1009), *range(len(data) - 200, len(data))]:
        run = opened(path, data[:end])
        assert len(run.warnings) == 1 and "ends in the middle" in run.warnings[0], end
        found = {topic: messages(run, topic) for topic in expected}
        for topic, all_of_it in expected.items():
            assert found[topic] == all_of_it[: len(found[topic])]
        count = sum(map(len, found.values()))
        assert f"read {count} whole" in run.warnings[0] and count >= most
        most = count
    assert most == sum(map(len, expected.values()))
    assert opened(path, data).warnings == []
    for end in range(8):
        with pytest.raises(squirm.NotARecording):
            opened(path, data[:end])


def test_every_flipped_bit_of_a_finished_file_is_found(whole, tmp_path):
    data, _ = whole
    draw = random.Random(5)
    bits = [draw.randrange(8 * len(data)) for _ in range(300)] + [8 * (len(data) - i) - 1 for i in range(1, 100)]
    for bit in bits:
        bad = bytearray(data)
        bad[bit // 8] ^= 1 << bit % 8
        with pytest.raises((squirm.DamagedRecording, squirm.NotARecording)):
            opened(tmp_path / "run.mcap", bad)


def test_a_flipped_bit_before_a_missing_end_gives_nothing_that_is_wrong(whole, tmp_path):
    data, expected = whole
    draw = random.Random(6)
    cut = data[: 2 * len(data) // 3]
    refused = 0
    for _ in range(300):
        bit = draw.randrange(8 * len(cut))
        bad = bytearray(cut)
        bad[bit // 8] ^= 1 << bit % 8
        try:
            run = opened(tmp_path / "run.mcap", bad)
        except (squirm.DamagedRecording, squirm.NotARecording):
            refused += 1
            continue
        assert run.warnings
        for topic, all_of_it in expected.items():
            found = messages(run, topic)
            assert found == all_of_it[: len(found)], bit
    assert refused > 240


def test_damage_names_the_file_and_the_cure(whole, tmp_path):
    data, _ = whole
    bad = bytearray(data)
    bad[len(data) // 2] ^= 4
    with pytest.raises(squirm.DamagedRecording, match=r"run\.mcap is damaged at byte \d+: .*squirm recover"):
        opened(tmp_path / "run.mcap", bad)


def test_a_file_that_changes_after_it_was_opened_is_noticed(whole, tmp_path):
    data, _ = whole
    run = opened(tmp_path / "run.mcap", data)
    bad = bytearray(data)
    for byte in range(2000, len(bad), 50):
        bad[byte] ^= 1
    (tmp_path / "run.mcap").write_bytes(bad)
    with pytest.raises(squirm.DamagedRecording):
        run.array("squirmers", "position")


def written(path, source, steps, metadata=True):
    """A recording with those snapshots of `source` whose step is in `steps`, one chunk each."""
    with source.open("rb") as file, path.open("wb") as out:
        reader = make_reader(file)
        writer = Writer(out, chunk_size=1)
        writer.start(profile="", library="test")
        channels = {}
        for record in reader.iter_metadata() if metadata else ():
            writer.add_metadata(record.name, record.metadata)
        for schema, channel, message in reader.iter_messages():
            if channel.topic.startswith("/squirm/") and squirm.Snapshot(message.data).step in steps:
                if channel.id not in channels:
                    new = writer.register_schema(schema.name, schema.encoding, schema.data)
                    channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, new)
                writer.add_message(
                    channels[channel.id], message.log_time, message.data, message.publish_time, message.sequence
                )
        writer.finish()


def test_segments_are_one_run_and_the_later_one_counts(whole, folder, tmp_path):
    _, expected = whole
    # Killed after step 24, resumed from a state at step 14: 16 to 24 are there twice.
    written(tmp_path / "run.mcap", folder / "run.mcap", range(0, 25))
    written(tmp_path / "run.0001.mcap", folder / "run.mcap", range(15, 33))
    written(tmp_path / "run.0002.mcap", folder / "run.mcap", range(33, 99))
    for place in (tmp_path, tmp_path / "run.mcap"):
        run = squirm.open_run(place)
        assert [p.name for p in run.paths] == ["run.mcap", "run.0001.mcap", "run.0002.mcap"]
        for topic, all_of_it in expected.items():
            assert messages(run, topic) == all_of_it and run.frames(topic).lost == 0
    assert squirm.open_run(tmp_path / "run.0001.mcap").squirmers.step.tolist() == [16, 20, 24, 28, 32]
    # The first one lost its end to the kill; nothing of it was needed.
    first = tmp_path / "run.mcap"
    first.write_bytes(first.read_bytes()[:-100])
    assert messages(squirm.open_run(tmp_path), "fields") == expected["fields"]
    (tmp_path / "run.0001.mcap").unlink()
    with pytest.warns(squirm.RecordingWarning, match="2 snapshots of scalars are missing between the segments"):
        assert squirm.open_run(tmp_path).scalars.step.tolist() == [0, 4, 8, 12, 16, 20, 24, 36, 40]


def test_the_fluid_may_begin_in_a_later_segment(folder, tmp_path):
    written(tmp_path / "run.mcap", folder / "run.mcap", range(9))
    written(tmp_path / "run.fluid.0001.mcap", folder / "run.fluid.mcap", [20])
    written(tmp_path / "run.fluid.0002.mcap", folder / "run.fluid.mcap", [40])
    assert squirm.open_run(tmp_path).particles.step.tolist() == [20, 40]
    written(tmp_path / "run.fluid.mcap", folder / "run.fluid.mcap", [0])
    assert squirm.open_run(tmp_path / "run.fluid.mcap").particles.step.tolist() == [0, 20, 40]


def test_missing_snapshots_are_counted(folder, tmp_path):
    written(tmp_path / "run.mcap", folder / "run.mcap", [0, 4, 16, 20, 28])
    run = squirm.open_run(tmp_path)
    assert (run.squirmers.lost, run.scalars.frames.lost, run.squirmers[:2].lost) == (3, 3, 0)


def test_other_files_are_no_recordings(folder, tmp_path):
    written(tmp_path / "run.mcap", folder / "run.mcap", [], metadata=False)
    with pytest.raises(squirm.NotARecording, match="no recording of squirm"):
        squirm.open_run(tmp_path)


def test_a_chunk_that_passes_for_another_record_is_found(whole, tmp_path):
    """One flipped bit makes a chunk an index of messages; without the file's end no checksum covers that bit."""
    data, _ = whole
    cut = data[: len(data) // 2]
    offset, chunks = 8, 0
    while offset + 9 <= len(cut):
        opcode, length = struct.unpack_from("<BQ", cut, offset)
        if opcode == Opcode.CHUNK and offset + 9 + length <= len(cut):
            bad = bytearray(cut)
            bad[offset] ^= Opcode.CHUNK ^ Opcode.MESSAGE_INDEX
            with pytest.raises(squirm.DamagedRecording, match="index of messages"):
                opened(tmp_path / "run.mcap", bad)
            chunks += 1
        offset += 9 + length
    assert chunks > 5
