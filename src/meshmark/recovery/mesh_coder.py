"""Coding of a small triangle mesh with whole-number coordinates: faces are walked edge by edge.

Across each known edge the coder says whether there is no face, one with a new point, or one with a known point,
told by its rank among the points still on the border, nearest first to where a parallelogram would have it. New
points are told by what they are off that place, along the plane of the face before and out of it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import numpy as np

from meshmark.errors import CapacityError, InputError
from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.range_coder import Decoder, Encoder, Model

__all__ = ["PLACE_BITS", "decode_mesh", "encode_mesh"]

NOTHING, NEW, KNOWN = 0, 1, 2
# Ranks beyond these are written as plain numbers of so many bits.
RANKS, PLAIN = 7, 16
# The first points of a part are written plainly; how many bits they need is written once, in so many.
REACH = 4
PLACE_BITS = 2**REACH - 1
"""Places of so many bits and a sign can be coded."""
# Distance of the nearest known point from the predicted place, in edge lengths: contexts of the models.
NEAR = (0.35, 0.6, 0.9, 1.3)
LENGTHS = 18
_KINDS = [[1, 2, 30], [1, 8, 16], [1, 16, 8], [1, 24, 4], [1, 30, 2]]
MOST_POINTS = 60_000


class _Models:
    """The models of both sides; they learn alike."""

    def __init__(self, bits: int) -> None:
        self.kind = [Model(first) for first in _KINDS]
        self.rank = [Model([40, 8, 4, 2, 1, 1, 1, 1]) for _ in _KINDS]
        self.more = Model([2, 1])
        likely = [1 + 12 * max(0, 3 - abs(length - (bits - 3))) for length in range(LENGTHS)]
        self.length = [Model(likely) for _ in range(3)]
        self.high = [[Model([1, 1]) for _ in range(LENGTHS)] for _ in range(3)]


class _Walk:
    """What both sides know after each step: points, border edges, and the edges still to be crossed."""

    def __init__(self, bits: int) -> None:
        self.places = np.zeros((MOST_POINTS, 3))
        self.count = 0
        self.open = np.zeros(MOST_POINTS, np.int64)
        self.known: set[tuple[int, int]] = set()
        self.gates: deque[tuple[int, int, int]] = deque()
        self.models = _Models(bits)
        self.faces: list[tuple[int, int, int]] = []

    def add_point(self, place: FloatArray) -> int:
        if self.count == MOST_POINTS:
            raise InputError(f"a miniature has too many points, expected at most {MOST_POINTS}")
        self.places[self.count] = place
        self.count += 1
        return self.count - 1

    def add_face(self, a: int, b: int, c: int) -> None:
        self.faces.append((a, b, c))
        for start, end, across in ((a, b, c), (b, c, a), (c, a, b)):
            self.known.add((start, end))
            if (end, start) in self.known:
                self.open[[start, end]] -= 1
            else:
                self.open[[start, end]] += 1
                self.gates.append((end, start, across))

    def next_gates(self) -> Iterator[tuple[int, int, int]]:
        """Yield directed edges that a further face may have, and the point on the other side."""
        while self.gates:
            a, b, across = self.gates.popleft()
            if (a, b) not in self.known:
                yield a, b, across

    def predicted(self, a: int, b: int, across: int) -> tuple[FloatArray, FloatArray]:
        """Return where a parallelogram would have the next point, and axes (3, 3): along, off, out."""
        start, end, other = self.places[a], self.places[b], self.places[across]
        along = _unit(end - start)
        out = _unit(_cross(end - start, start - other))
        return start + end - other, np.stack([along, _cross(out, along), out])

    def ranking(self, a: int, b: int, place: FloatArray) -> tuple[IntArray, int]:
        """Return the border points, nearest to `place` first, and the context."""
        self.open[[a, b]] += 1 << 30
        rows = np.flatnonzero((self.open[: self.count] > 0) & (self.open[: self.count] < 1 << 29))
        self.open[[a, b]] -= 1 << 30
        squared = ((self.places[rows] - place) ** 2).sum(axis=1)
        edge = self.places[a] - self.places[b]
        order = rows[np.argsort(squared, kind="stable")]
        nearest = float(squared.min()) if len(rows) else np.inf
        share = (nearest / max(float(edge @ edge), 1.0)) ** 0.5
        return order, int(np.searchsorted(NEAR, share))


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return a x b of two vectors (3,): numpy's own takes ten times as long for so few numbers."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def _unit(vector: FloatArray) -> FloatArray:
    length = float(vector @ vector) ** 0.5
    return vector / length if length > 0.0 else np.zeros(3)


def encode_mesh(places: FloatArray, faces: IntArray, bits: int) -> bytes:
    """Return the bytes of a mesh; places: (p, 3) in quantiser steps, most within +-2^(bits - 1); faces: (m, 3).

    A point comes back within half a step along each axis. Faces that share an edge with two others, or disagree
    with their neighbour about the side, come back, too, as seeds of their own. Raises `CapacityError` for places of
    2^PLACE_BITS steps and more.
    """
    walk, out = _Walk(bits), Encoder()
    reach = int(np.abs(np.rint(places)).max(initial=0.0)).bit_length()
    if reach > PLACE_BITS:
        raise CapacityError(
            "parts of the model lie too far from each other for a miniature, expected nearer ones"
        )
    out.bits(reach, REACH)
    left = {tuple(int(corner) for corner in face) for face in faces}
    over: dict[tuple[int, int], list[tuple[int, int, int]]] = {}
    for a, b, c in sorted(left):
        for start, end, across in ((a, b, c), (b, c, a), (c, a, b)):
            over.setdefault((start, end), []).append((start, end, across))
    number: dict[int, int] = {}
    back: list[int] = []
    for seed in sorted(left):
        if seed not in left:
            continue
        left.discard(seed)
        out.symbol(walk.models.more, 0)
        corners = [_encode_seed(out, walk, number, back, places, corner, reach) for corner in seed]
        walk.add_face(*corners)
        for a, b, across in walk.next_gates():
            face = next((f for f in over.get((back[a], back[b]), []) if _as_set(f, left)), None)
            _encode_gate(out, walk, number, back, places, (a, b, across), face)
            if face is not None:
                left.discard(_as_set(face, left) or face)
                walk.add_face(a, b, number[face[2]])
    out.symbol(walk.models.more, 1)
    return out.finish()


def _as_set(face: tuple[int, int, int], left: set[tuple[int, ...]]) -> tuple[int, int, int] | None:
    a, b, c = face
    return next((turned for turned in ((a, b, c), (b, c, a), (c, a, b)) if turned in left), None)


def _encode_seed(
    out: Encoder,
    walk: _Walk,
    number: dict[int, int],
    back: list[int],
    places: FloatArray,
    corner: int,
    reach: int,
) -> int:
    if corner in number:
        out.bits(1, 1)
        out.bits(number[corner], PLAIN)
        return number[corner]
    out.bits(0, 1)
    whole = np.rint(places[corner]).astype(int)
    for value in whole:
        out.bits(int(value + (1 << reach)), reach + 1)
    number[corner] = walk.add_point(whole.astype(float))
    back.append(corner)
    return number[corner]


def _encode_gate(
    out: Encoder,
    walk: _Walk,
    number: dict[int, int],
    back: list[int],
    places: FloatArray,
    gate: tuple[int, int, int],
    face: tuple[int, int, int] | None,
) -> None:
    place, axes = walk.predicted(*gate)
    order, context = walk.ranking(gate[0], gate[1], place)
    kind = walk.models.kind[context]
    if face is None:
        out.symbol(kind, NOTHING)
        return
    tip = face[2]
    if tip not in number:
        out.symbol(kind, NEW)
        off = np.rint(axes @ (places[tip] - place)).astype(int)
        for axis, value in enumerate(off):
            _encode_number(out, walk.models, axis, int(value))
        number[tip] = walk.add_point(place + off @ axes)
        back.append(tip)
        return
    out.symbol(kind, KNOWN)
    rank = int(np.argmax(order == number[tip])) if (order == number[tip]).any() else RANKS
    out.symbol(walk.models.rank[context], min(rank, RANKS))
    if rank >= RANKS:
        out.bits(number[tip], PLAIN)


def _encode_number(out: Encoder, models: _Models, axis: int, value: int) -> None:
    size = abs(value)
    length = size.bit_length()
    out.symbol(models.length[axis], length)
    if length > 1:
        rest = size - (1 << (length - 1))
        top = rest >> (length - 2)
        out.symbol(models.high[axis][length], top)
        if length > 2:
            out.bits(rest & ((1 << (length - 2)) - 1), length - 2)
    if size:
        out.bits(int(value < 0), 1)


def decode_mesh(content: bytes, bits: int) -> tuple[FloatArray, IntArray]:
    """Return places (p, 3) and faces (m, 3); raises `InputError` for damaged content."""
    walk, read = _Walk(bits), Decoder(content)
    reach = read.bits(REACH)
    while read.symbol(walk.models.more) == 0:
        walk.add_face(*(_decode_seed(read, walk, reach) for _ in range(3)))
        for gate in walk.next_gates():
            tip = _decode_gate(read, walk, gate)
            if tip is not None:
                walk.add_face(gate[0], gate[1], tip)
            if read.exhausted:
                raise InputError("the miniature ends too early, expected more bytes")
        if read.exhausted:
            raise InputError("the miniature ends too early, expected more bytes")
    return walk.places[: walk.count].copy(), np.array(walk.faces, np.int64).reshape(-1, 3)


def _decode_seed(read: Decoder, walk: _Walk, reach: int) -> int:
    if read.bits(1):
        return _known(walk, read.bits(PLAIN))
    return walk.add_point(np.array([float(read.bits(reach + 1) - (1 << reach)) for _ in range(3)]))


def _decode_gate(read: Decoder, walk: _Walk, gate: tuple[int, int, int]) -> int | None:
    place, axes = walk.predicted(*gate)
    order, context = walk.ranking(gate[0], gate[1], place)
    kind = read.symbol(walk.models.kind[context])
    if kind == NOTHING:
        return None
    if kind == NEW:
        off = np.array([_decode_number(read, walk.models, axis) for axis in range(3)])
        return walk.add_point(place + off @ axes)
    rank = read.symbol(walk.models.rank[context])
    if rank < RANKS:
        if rank >= len(order):
            raise InputError("the miniature names a point that it does not have, expected an earlier one")
        return int(order[rank])
    return _known(walk, read.bits(PLAIN))


def _decode_number(read: Decoder, models: _Models, axis: int) -> int:
    length = read.symbol(models.length[axis])
    if not length:
        return 0
    size = 1
    if length > 1:
        size = (1 << (length - 1)) | (read.symbol(models.high[axis][length]) << (length - 2))
        if length > 2:
            size |= read.bits(length - 2)
    return -size if read.bits(1) else size


def _known(walk: _Walk, number: int) -> int:
    if number >= walk.count:
        raise InputError("the miniature names a point that it does not have, expected an earlier one")
    return number
