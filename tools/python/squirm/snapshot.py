"""One snapshot message: its header, its column table, and its columns as views of its bytes (docs/format.md)."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .errors import NoSuchColumn, NotASnapshot

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Kinds of snapshots in the order of their numbers, which begin with 1.
TOPICS = ("squirmers", "scalars", "fields", "particles")

MAGIC = b"\x89SQRM\r\n\x1a"
VERSION = 1
HEADER = struct.Struct("<8sII16sQdQQQQ3ddQIIII3I8sI")
_ENTRY = struct.Struct("<24s16sIIQQ")
_DTYPES: dict[int, np.dtype[Any]] = {1: np.dtype("u1"), 2: np.dtype("<u4"), 3: np.dtype("<f4"), 4: np.dtype("<f8")}
_WALLS_Y = 1
_SET = object.__setattr__


class Header(NamedTuple):
    """The fixed head of a message."""

    kind: str
    run_id: bytes
    step: int
    time: float
    seq: int
    bytes: int
    rows: int
    population: int
    box_size: tuple[float, float, float]
    fraction: float
    every: int
    walls: bool
    columns: int
    table: int
    block: int
    blocks: tuple[int, int, int]


class _Column(NamedTuple):
    unit: str
    dtype: np.dtype[Any]
    components: int
    offset: int
    rows: int


@dataclass(frozen=True)
class Species:
    """What the squirmers of one species have in common."""

    #: Name in the pipeline file.
    name: str
    #: Semi-axis along the swimming axis, in a.
    along: float
    #: Semi-axes across it, in a.
    across: float
    #: B1 in sqrt(kT/m).
    b1: float
    #: Active stress: above 0 pullers, below 0 pushers.
    beta: float
    #: Rotlet dipole C2 in sqrt(kT/m).
    rotlet: float
    #: Swimming speed that theory predicts in an unbounded fluid, in sqrt(kT/m); NaN if unknown.
    u0: float


class Snapshot:
    """Columns of one topic at one moment, as read-only numpy arrays on the bytes of the message.

    A column is an attribute (``s.position``) and an item (``s["position"]``); ``s.unit("position")`` is its unit.
    Columns with one value a row have the shape (rows,), others (rows, components), and those of fields (nz, ny, nx)
    and (nz, ny, nx, 3). Nothing is copied. Arrays stay valid as long as they exist; but of a live run only two
    snapshots of a topic can be held at a time (see :meth:`copy`).
    """

    __slots__ = ("_buffer", "_columns", "_header")

    if TYPE_CHECKING:
        _buffer: memoryview
        _columns: dict[str, _Column]
        _header: Header
        #: Squirmers: number, stable over the run.
        id: NDArray[np.uint32]
        #: Squirmers: index into :attr:`species_table`.
        species: NDArray[np.uint32]
        #: Squirmers and particles: place in a, in [0, L).
        position: NDArray[np.float32]
        #: Squirmers: centre in a, followed through the periodic boundaries.
        unwrapped: NDArray[np.float64]
        #: Squirmers: swimming axis, a unit vector.
        axis: NDArray[np.float32]
        #: Squirmers: quaternion x, y, z, w from body to lab axes; the body's z axis is the swimming axis.
        orientation: NDArray[np.float32]
        #: Velocity in sqrt(kT/m) of squirmers, particles, or the fluid in a block (zero where it is empty).
        velocity: NDArray[np.float32]
        #: Squirmers: angular velocity in 1/tau, lab frame.
        angular_velocity: NDArray[np.float32]
        #: Squirmers: force in kT/a.
        force: NDArray[np.float32]
        #: Squirmers: torque about the centre in kT.
        torque: NDArray[np.float32]
        #: Fields: mass density in m/a^3.
        density: NDArray[np.float32]
        #: Particles, if all of them are there: what rounding took from the position, in a.
        position_rest: NDArray[np.float32]

    def __init__(self, message: Any) -> None:
        """Checks header, checksum and column table of a message.

        `message` is anything with a buffer of bytes; it may be longer than the message.

        Raises NotASnapshot if it was not written by a squirm of this version, or is damaged.
        """
        buffer = memoryview(message).toreadonly().cast("B")
        header = read_header(buffer)
        buffer = buffer[: header.bytes]
        columns: dict[str, _Column] = {}
        for at in range(header.table, header.table + header.columns * _ENTRY.size, _ENTRY.size):
            name, column = _column(buffer, at)
            columns.setdefault(name, column)
        _SET(self, "_buffer", buffer)
        _SET(self, "_header", header)
        _SET(self, "_columns", columns)

    @property
    def kind(self) -> str:
        """The topic: one of TOPICS."""
        return self._header.kind

    @property
    def run_id(self) -> bytes:
        """16 bytes, the same for all messages of one run."""
        return self._header.run_id

    @property
    def step(self) -> int:
        """Collision steps done."""
        return self._header.step

    @property
    def time(self) -> float:
        """Simulated time in tau."""
        return self._header.time

    @property
    def seq(self) -> int:
        """Snapshots before this one; a jump means that some were lost."""
        return self._header.seq

    @property
    def every(self) -> int:
        """Steps between two snapshots; 0 if not fixed."""
        return self._header.every

    @property
    def rows(self) -> int:
        """Squirmers, scalars, blocks or particles in the message."""
        return self._header.rows

    @property
    def population(self) -> int:
        """How many there are in the run; more than `rows` where only a share is sent."""
        return self._header.population

    @property
    def fraction(self) -> float:
        """Share of the population that was asked for."""
        return self._header.fraction

    @property
    def box_size(self) -> NDArray[np.float64]:
        """Edges of the box along x, y and z in a."""
        return np.array(self._header.box_size)

    @property
    def walls(self) -> bool:
        """Whether there are walls at y = 0 and y = L; without them y is periodic, as x and z always are."""
        return self._header.walls

    @property
    def block(self) -> int:
        """Fields: edge of a block in a; else 0. The last block of an axis may stick out of the box."""
        return self._header.block

    @property
    def blocks(self) -> tuple[int, int, int]:
        """Fields: blocks along x, y and z; else zeros. Arrays have the shape (nz, ny, nx)."""
        return self._header.blocks

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(self._columns)

    @property
    def message(self) -> memoryview:
        """All bytes of the message."""
        return self._buffer

    @property
    def scalars(self) -> dict[str, float]:
        """Scalars: value by name."""
        return dict(zip(self._scalar_texts("name"), self["value"].tolist(), strict=True))

    @property
    def species_table(self) -> list[Species]:
        """Squirmers: the species, in the order of the numbers in the column `species`."""
        names = self.texts("species.name")
        numbers = [self[f"species.{name}"] for name in ("semi_axes", "b1", "beta", "rotlet", "u0")]
        if any(len(column) != len(names) for column in numbers) or numbers[0].shape[1:] != (2,):
            raise NotASnapshot("the species' columns do not fit together")
        rows = zip(names, *(column.tolist() for column in numbers), strict=True)
        return [Species(name, along, across, *rest) for name, (along, across), *rest in rows]

    def unit(self, name: str) -> str:
        """Unit of a column, or of a scalar of this name; empty for pure numbers. Raises NoSuchColumn."""
        if self.kind == "scalars" and name not in self._columns:
            units = dict(zip(self._scalar_texts("name"), self._scalar_texts("unit"), strict=True))
            if name in units:
                return units[name]
        return self._find(name).unit

    def texts(self, name: str) -> list[str]:
        """A column of texts, such as `species.name`. Raises NoSuchColumn."""
        column = self[name]
        if column.dtype != np.uint8:
            raise NotASnapshot(f"column `{name}` holds {column.dtype}, not text")
        return [_text(bytes(row)) for row in column.reshape(column.shape[0], -1)]

    def copy(self) -> Snapshot:
        """The same snapshot in memory of its own, for keeping snapshots of a live run."""
        return Snapshot(bytes(self._buffer))

    def __getitem__(self, name: str) -> NDArray[Any]:
        column = self._find(name)
        shape: tuple[int, ...] = (column.rows,)
        # Columns with a dot in their names belong to something else than the rows, such as the species.
        if "." not in name:
            if column.rows != self.rows:
                raise NotASnapshot(f"column `{name}` has {column.rows} rows in a message of {self.rows}")
            if self.kind == "fields":
                shape = self.blocks[::-1]
                if self.blocks[0] * self.blocks[1] * self.blocks[2] != column.rows:
                    raise NotASnapshot(f"{column.rows} values on a grid of {self.blocks} blocks")
        if column.components > 1:
            shape += (column.components,)
        return np.ndarray(shape, column.dtype, self._buffer, column.offset)

    def __getattr__(self, name: str) -> NDArray[Any]:
        if name.startswith("_"):
            raise AttributeError(name)
        return self[name]

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError("snapshots cannot be changed")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(name for name in self._columns if "." not in name)]

    def __reduce__(self) -> tuple[type[Snapshot], tuple[bytes]]:
        return Snapshot, (bytes(self._buffer),)

    def __repr__(self) -> str:
        columns = ", ".join(f"{n} [{c.unit}]" if c.unit else n for n, c in self._columns.items())
        return f"<{self.kind} at step {self.step}, t = {self.time:g} tau, {self.rows} rows: {columns}>"

    def _find(self, name: str) -> _Column:
        column = self._columns.get(name)
        if column is None:
            raise NoSuchColumn(f"a snapshot of {self.kind} has no `{name}`; it has {', '.join(self._columns)}")
        return column

    def _scalar_texts(self, name: str) -> list[str]:
        texts = self.texts(name)
        if len(texts) != self.rows:
            raise NotASnapshot("the scalars' columns have different lengths")
        return texts


def read_header(buffer: memoryview) -> Header:
    """The header of a message of which nothing is trusted. Raises NotASnapshot."""
    have = len(buffer)
    if have < HEADER.size:
        raise NotASnapshot(f"{have} bytes are too few for a snapshot")
    (magic, version, kind, run_id, step, time, seq, length, rows, population, x, y, z, fraction, every, flags, columns,
     table, block, nx, ny, nz, _, checksum) = HEADER.unpack_from(buffer)  # fmt: skip
    if magic != MAGIC:
        raise NotASnapshot("the bytes do not begin as a snapshot does")
    if version != VERSION:
        raise NotASnapshot(f"snapshots of version {version}; this package reads version {VERSION}")
    if length > have:
        raise NotASnapshot(f"the message ends after {have} of {length} bytes")
    end = table + columns * _ENTRY.size
    if table < HEADER.size or end > length:
        raise NotASnapshot("the column table lies outside the message")
    computed = zlib.crc32(buffer[table:end], zlib.crc32(buffer[: HEADER.size - 4]))
    if computed != checksum:
        raise NotASnapshot(f"the header is damaged: checksum {checksum:#010x}, computed {computed:#010x}")
    if not 1 <= kind <= len(TOPICS):
        raise NotASnapshot(f"unknown kind {kind}")
    return Header(
        TOPICS[kind - 1], run_id, step, time, seq, length, rows, population, (x, y, z), fraction, every,
        bool(flags & _WALLS_Y), columns, table, block, (nx, ny, nz),
    )  # fmt: skip


def _column(buffer: memoryview, at: int) -> tuple[str, _Column]:
    """Name and description of the column whose table entry begins at `at`, with its values inside the message."""
    raw_name, raw_unit, element, components, offset, rows = _ENTRY.unpack_from(buffer, at)
    name = _text(raw_name)
    dtype = _DTYPES.get(element)
    if dtype is None:
        raise NotASnapshot(f"column `{name}` has an unknown element type, {element}")
    if components == 0 or offset % 8 != 0:
        raise NotASnapshot(f"column `{name}` has no components, or is not aligned to 8 bytes")
    if offset + rows * components * dtype.itemsize > len(buffer):
        raise NotASnapshot(f"column `{name}` lies outside the message")
    return name, _Column(_text(raw_unit), dtype, components, offset, rows)


def _text(raw: bytes) -> str:
    """The text before the zeros; empty if it is not UTF-8, as the other readers have it."""
    try:
        return raw.split(b"\0", 1)[0].decode()
    except UnicodeDecodeError:
        return ""
