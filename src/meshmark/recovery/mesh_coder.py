"""Coding of a small triangle mesh with coordinates in quantiser steps: faces are walked edge by edge.

Across each known edge the coder says whether there is no face, one with a new point, one that closes the gap to a
neighbouring edge of the border, or one with another known point, given by its rank among the points of the border,
nearest first to where a parallelogram would have it. New points are given by their offset from that place, along
the edge, in the plane of the face before, and out of it: there in finer steps, as a surface shows that most.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from meshmark.errors import CapacityError, InputError
from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.mesh_models import (
    GAP,
    KNOWN,
    LEADING,
    LENGTHS,
    NEAR,
    NEW,
    NO_GAP,
    NOTHING,
    RANKS,
    SEED,
    MeshModels,
)
from meshmark.recovery.mesh_walk import Gate, MeshWalk, Point, Prediction
from meshmark.recovery.range_coder import Decoder, Encoder, Model

__all__ = ["PLACE_BITS", "decode_mesh", "encode_mesh", "estimated_size"]

# Known points of higher rank are written as plain numbers of PLAIN bits.
PLAIN = 16
# The first points of a part are written plainly; how many bits they need is written once, in REACH bits.
REACH = 4
PLACE_BITS = 2**REACH - 1
"""Places of this many bits and a sign can be coded."""
# Steps out of the plane in a step along it.
FINER = 3.0

Corners = tuple[int, int, int]


def encode_mesh(places: FloatArray, faces: IntArray) -> bytes:
    """Return the bytes of a mesh; places: (p, 3) in quantiser steps; faces: (m, 3).

    A point comes back within half a step along each axis. Faces that share an edge with two others, or disagree
    with their neighbour about the side, come back, too, as seeds of their own. Raises `CapacityError` for places of
    2^PLACE_BITS steps and more.
    """
    return _encoded(places, faces, len(places))[0]


def estimated_size(places: FloatArray, faces: IntArray, most: int) -> float:
    """Return about how many bytes `encode_mesh` takes for a mesh, from those of its first `most` points."""
    content, done = _encoded(places, faces, most)
    return len(content) * len(places) / done


def _encoded(places: FloatArray, faces: IntArray, most: int) -> tuple[bytes, int]:
    """Return the bytes of the part of a mesh that is walked until it has `most` points, and how many it has."""
    walk, out = MeshWalk(), Encoder()
    reach = int(np.abs(np.rint(places)).max(initial=0.0)).bit_length()
    if reach > PLACE_BITS:
        raise CapacityError(
            "parts of the model lie too far from each other for a miniature, expected nearer ones"
        )
    out.bits(reach, REACH)
    seeds: list[Corners] = [(a, b, c) for a, b, c in sorted(faces.tolist())]
    left = set(seeds)
    over: dict[tuple[int, int], list[int]] = {}
    for a, b, c in seeds:
        for start, end, across in ((a, b, c), (b, c, a), (c, a, b)):
            over.setdefault((start, end), []).append(across)
    points: list[Point] = [(x, y, z) for x, y, z in places.tolist()]
    mesh = _Encoding(out=out, walk=walk, models=MeshModels(), places=points, reach=reach)
    most = most if most < len(places) else len(places) + 1
    for seed in seeds:
        if len(walk.places) >= most:
            break
        if seed not in left:
            continue
        left.discard(seed)
        out.symbol(mesh.models.more, 0)
        first = mesh.encode_seed(seed[0], None)
        walk.add_face(first, *(mesh.encode_seed(corner, walk.places[first]) for corner in seed[1:]))
        for gate in walk.next_gates():
            if len(walk.places) >= most:
                break
            a, b = mesh.back[gate[0]], mesh.back[gate[1]]
            tip = None
            for across in over.get((a, b), ()):
                face = next((turned for turned in _turned(a, b, across) if turned in left), None)
                if face is not None:
                    left.discard(face)
                    tip = across
                    break
            mesh.encode_gate(gate, tip)
            if tip is not None:
                walk.add_face(gate[0], gate[1], mesh.number[tip])
    out.symbol(mesh.models.more, 1)
    return out.finish(), len(walk.places)


def _turned(a: int, b: int, c: int) -> tuple[Corners, Corners, Corners]:
    return (a, b, c), (b, c, a), (c, a, b)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Encoding:
    """The encoder's side of a walk.

    places: in quantiser steps; reach: bits of the coordinates of a seed. number: of each point of the mesh that was
    coded, its number in the walk; back: the other way round.
    """

    out: Encoder
    walk: MeshWalk
    models: MeshModels
    places: list[Point]
    reach: int
    number: dict[int, int] = field(default_factory=dict)
    back: list[int] = field(default_factory=list)

    def encode_seed(self, corner: int, first: Point | None) -> int:
        """Write a corner of a part's first face beside its first corner, and return its number."""
        out, number = self.out, self.number
        if corner in number:
            out.symbol(self.models.seen, 1)
            out.bits(number[corner], PLAIN)
            return number[corner]
        out.symbol(self.models.seen, 0)
        whole = [round(value) for value in self.places[corner]]
        for axis, value in enumerate(whole):
            if first is None:
                out.bits(value + (1 << self.reach), self.reach + 1)
            else:
                _encode_number(out, self.models, (SEED, self.reach), value - round(first[axis]))
        return self._add(corner, (float(whole[0]), float(whole[1]), float(whole[2])))

    def encode_gate(self, gate: Gate, tip: int | None) -> None:
        """Write what lies across an edge: no face, or one whose third corner is `tip`."""
        out, walk, number = self.out, self.walk, self.number
        seen = walk.predicted(gate)
        gap, leading, kind = _beyond(walk, self.models, gate, seen)
        if tip is None:
            out.symbol(kind, NOTHING)
        elif tip not in number:
            out.symbol(kind, NEW)
            self._add(tip, self._encode_offset(seen, self.places[tip]))
        elif number[tip] == gap:
            out.symbol(kind, GAP)
        elif number[tip] == leading:
            out.symbol(kind, LEADING)
        else:
            out.symbol(kind, KNOWN)
            order = walk.border(seen.place)[:RANKS]
            rank = order.index(number[tip]) if number[tip] in order else RANKS
            out.symbol(self.models.rank, rank)
            if rank == RANKS:
                out.bits(number[tip], PLAIN)

    def _encode_offset(self, seen: Prediction, place: Point) -> Point:
        """Write where a new point is, and return the place that a reader has then."""
        x, y, z = place[0] - seen.place[0], place[1] - seen.place[1], place[2] - seen.place[2]
        size = min(int(seen.length).bit_length(), LENGTHS - 1)
        off = []
        for axis, (u, v, w) in enumerate((seen.along, seen.off, seen.out)):
            share = u * x + v * y + w * z
            value = round(FINER * share if axis == 2 else share)
            _encode_number(self.out, self.models, (axis, size), value)
            off.append(value)
        return _moved(seen, off)

    def _add(self, corner: int, place: Point) -> int:
        self.number[corner] = self.walk.add_point(place)
        self.back.append(corner)
        return self.number[corner]


def _beyond(
    walk: MeshWalk, models: MeshModels, gate: Gate, seen: Prediction
) -> tuple[int | None, int | None, Model]:
    """Return the points that the border beside a gate leads to, and the model of what lies beyond it."""
    gap, leading = walk.gap(gate), walk.leading(gate)
    unit = max(seen.length * seen.length, 1.0)
    x, y, z = seen.place

    def class_of(point: int | None) -> int:
        if point is None:
            return NO_GAP
        u, v, w = walk.places[point]
        share = ((u - x) * (u - x) + (v - y) * (v - y) + (w - z) * (w - z)) / unit
        return 0 if share < NEAR[0] else 1 if share < NEAR[1] else 2

    classes = class_of(gap), class_of(leading)
    return gap, leading, models.kind(classes, (walk.faces_at[gate[1]], walk.faces_at[gate[0]]))


def _moved(seen: Prediction, off: list[int]) -> Point:
    s, t, r = float(off[0]), float(off[1]), off[2] / FINER
    x, y, z = (seen.place[k] + s * seen.along[k] + t * seen.off[k] + r * seen.out[k] for k in range(3))
    return x, y, z


def _encode_number(out: Encoder, models: MeshModels, where: tuple[int, int], value: int) -> None:
    """Write an offset; where: its axis, and the bits of its gate's length."""
    axis, near = where
    size = abs(value)
    length = size.bit_length()
    out.symbol(models.length(axis, near), length)
    if length > 1:
        rest = size - (1 << (length - 1))
        out.symbol(models.high(axis, length - near), rest >> (length - 2))
        if length > 2:
            out.bits(rest & ((1 << (length - 2)) - 1), length - 2)
    if size:
        out.symbol(models.sign(axis, length - near), int(value < 0))


def decode_mesh(content: bytes) -> tuple[FloatArray, IntArray]:
    """Return places (p, 3) and faces (m, 3); raises `InputError` for damaged content."""
    walk, models, read = MeshWalk(), MeshModels(), Decoder(content)
    reach = read.bits(REACH)
    while read.symbol(models.more) == 0:
        first = _decode_seed(read, walk, models, (reach, None))
        others = (_decode_seed(read, walk, models, (reach, walk.places[first])) for _ in range(2))
        walk.add_face(first, *others)
        for gate in walk.next_gates():
            tip = _decode_gate(read, walk, models, gate)
            if tip is not None:
                walk.add_face(gate[0], gate[1], tip)
            if read.exhausted:
                raise InputError("the miniature ends too early, expected more bytes")
        if read.exhausted:
            raise InputError("the miniature ends too early, expected more bytes")
    return np.array(walk.places, np.float64).reshape(-1, 3), np.array(walk.faces, np.int64).reshape(-1, 3)


def _decode_seed(read: Decoder, walk: MeshWalk, models: MeshModels, where: tuple[int, Point | None]) -> int:
    """Return a corner of a part's first face; where: the bits of a coordinate, and the first corner."""
    if read.symbol(models.seen):
        return _known(walk, read.bits(PLAIN))
    reach, first = where
    if first is None:
        x, y, z = (float(read.bits(reach + 1) - (1 << reach)) for _ in range(3))
    else:
        x, y, z = (round(start) + float(_decode_number(read, models, (SEED, reach))) for start in first)
    return walk.add_point((x, y, z))


def _decode_gate(read: Decoder, walk: MeshWalk, models: MeshModels, gate: Gate) -> int | None:
    seen = walk.predicted(gate)
    gap, leading, model = _beyond(walk, models, gate, seen)
    kind = read.symbol(model)
    if kind == NOTHING:
        return None
    if kind == NEW:
        size = min(int(seen.length).bit_length(), LENGTHS - 1)
        return walk.add_point(_moved(seen, [_decode_number(read, models, (axis, size)) for axis in range(3)]))
    if kind in (GAP, LEADING):
        return _there(gap if kind == GAP else leading)
    rank = read.symbol(models.rank)
    if rank == RANKS:
        return _known(walk, read.bits(PLAIN))
    order = walk.border(seen.place)
    return _there(order[rank] if rank < len(order) else None)


def _decode_number(read: Decoder, models: MeshModels, where: tuple[int, int]) -> int:
    axis, near = where
    length = read.symbol(models.length(axis, near))
    if not length:
        return 0
    size = 1
    if length > 1:
        size = (1 << (length - 1)) | (read.symbol(models.high(axis, length - near)) << (length - 2))
        if length > 2:
            size |= read.bits(length - 2)
    return -size if read.symbol(models.sign(axis, length - near)) else size


def _known(walk: MeshWalk, number: int) -> int:
    return _there(number if number < len(walk.places) else None)


def _there(point: int | None) -> int:
    if point is None:
        raise InputError("the miniature names a point that it does not have, expected an earlier one")
    return point
