"""Messages made by hand from docs/format.md, good and hostile."""

import struct
import zlib

import numpy as np
import pytest
import squirm


def message(columns, /, kind=1, rows=2, blocks=(0, 0, 0), **spoiled):
    """A message as docs/format.md has it; `spoiled` overwrites what its writer would compute."""
    table, values = b"", b""
    for name, unit, element, components, data, *changed in columns:
        offset = 160 + 64 * len(columns) + len(values)
        width = {1: 1, 2: 4, 3: 4, 4: 8}.get(element, 4)
        entry = {"offset": offset, "rows": len(data) // (components * width) if components else 0} | (
            changed[0] if changed else {}
        )
        table += struct.pack(
            "<24s16sIIQQ", name.encode(), unit.encode(), element, components, entry["offset"], entry["rows"]
        )
        values += data + bytes(-len(data) % 8)
    length = 160 + len(table) + len(values)
    length += -length % 16
    head = {
        "magic": b"\x89SQRM\r\n\x1a",
        "version": 1,
        "bytes": length,
        "columns": len(columns),
        "table": 160,
    } | spoiled
    packed = struct.pack(
        "<8sII16sQdQQQQ3ddQIIII3I8s",
        head["magic"], head["version"], kind, bytes(range(16)), 40, 2.0, 10, head["bytes"], rows, 5, 16.0, 8.0,
        12.0, 1.0, 4, 1, head["columns"], head["table"], 3, *blocks, bytes(8),
    )  # fmt: skip
    assert len(packed) == 156
    checksum = spoiled.get("checksum", zlib.crc32(packed + table))
    return (packed + struct.pack("<I", checksum) + table + values).ljust(length, b"\0")


POSITION = ("position", "a", 3, 3, np.arange(6, dtype="<f4").tobytes())
ID = ("id", "", 2, 1, np.array([7, 9], "<u4").tobytes())


def test_a_message_made_by_hand():
    snapshot = squirm.Snapshot(message([ID, POSITION]) + b"what follows in a larger buffer")
    assert (snapshot.kind, snapshot.step, snapshot.time, snapshot.seq, snapshot.every) == ("squirmers", 40, 2.0, 10, 4)
    assert (snapshot.rows, snapshot.population, snapshot.walls, snapshot.run_id) == (2, 5, True, bytes(range(16)))
    assert snapshot.box_size.tolist() == [16, 8, 12]
    assert snapshot.id.tolist() == [7, 9] and snapshot.id.shape == (2,)
    assert snapshot.position.tolist() == [[0, 1, 2], [3, 4, 5]]
    assert snapshot.unit("position") == "a" and snapshot.unit("id") == ""


def test_fields_have_the_shape_of_their_grid():
    density = ("density", "m/a^3", 3, 1, np.arange(24, dtype="<f4").tobytes())
    snapshot = squirm.Snapshot(message([density], kind=3, rows=24, blocks=(2, 3, 4)))
    assert snapshot.density.shape == (4, 3, 2)
    assert snapshot.density[3, 1, 0] == (3 * 3 + 1) * 2 + 0
    with pytest.raises(squirm.NotASnapshot, match="on a grid"):
        _ = squirm.Snapshot(message([density], kind=3, rows=24, blocks=(2, 3, 5))).density


def test_unknown_columns_and_empty_ones_are_no_trouble():
    empty = ("position", "a", 3, 3, b"")
    snapshot = squirm.Snapshot(message([("new", "1", 4, 1, b""), empty], rows=0))
    assert snapshot.position.shape == (0, 3) and snapshot.columns == ("new", "position")
    vast = ("position", "a", 4, 2**32 - 1, b"")
    assert squirm.Snapshot(message([vast], rows=0)).position.size == 0


@pytest.mark.parametrize(
    ("bad", "why"),
    [
        (message([POSITION], magic=b"\x89SQRM\n\x1a\0"), "do not begin"),
        (message([POSITION], version=2), "version 2"),
        (message([POSITION], bytes=2**63), "ends after"),
        (message([POSITION], bytes=160), "column table lies outside"),
        (message([POSITION], table=0), "column table lies outside"),
        (message([POSITION], table=2**32 - 1), "column table lies outside"),
        (message([POSITION], columns=2**32 - 1), "column table lies outside"),
        (message([POSITION], checksum=1), "damaged"),
        (message([POSITION], kind=0), "unknown kind 0"),
        (message([POSITION], kind=5), "unknown kind 5"),
        (message([(*POSITION[:2], 5, 3, b"")]), "unknown element type"),
        (message([(*POSITION[:2], 3, 0, b"")]), "no components"),
        (message([(*POSITION, {"offset": 2**63 - 8})]), "lies outside the message"),
        (message([(*POSITION, {"offset": 228})]), "not aligned"),
        (message([(*POSITION, {"rows": 2**64 - 1})]), "lies outside the message"),
        (message([POSITION])[:159], "too few"),
        (message([POSITION])[:-1], "ends after"),
        (b"", "too few"),
    ],
)
def test_hostile_messages_are_refused(bad, why):
    with pytest.raises(squirm.NotASnapshot, match=why):
        squirm.Snapshot(bad)


def test_columns_must_have_the_rows_of_the_message():
    with pytest.raises(squirm.NotASnapshot, match="2 rows in a message of 3"):
        _ = squirm.Snapshot(message([POSITION], rows=3)).position


def test_every_flipped_bit_of_header_and_table_is_seen():
    good = message([ID, POSITION])
    for bit in range(8 * (160 + 2 * 64)):
        bad = bytearray(good)
        bad[bit // 8] ^= 1 << bit % 8
        with pytest.raises(squirm.NotASnapshot):
            squirm.Snapshot(bad)
