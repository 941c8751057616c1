"""Coding of a small triangle mesh with whole-number coordinates: faces are walked edge by edge.

Across each known edge the coder says whether there is no face, one with a new point, or one with a known point,
given by its rank among the points still on the border, nearest first to where a parallelogram would have it. New
points are given by their offset from that place, along the plane of the face before and out of it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from meshmark.errors import CapacityError, InputError
from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.mesh_walk import MeshWalk, WalkModels
from meshmark.recovery.range_coder import Decoder, Encoder

__all__ = ["PLACE_BITS", "decode_mesh", "encode_mesh"]

NOTHING, NEW, KNOWN = 0, 1, 2
# Ranks from RANKS on are written as plain numbers of PLAIN bits.
RANKS, PLAIN = 7, 16
# The first points of a part are written plainly; how many bits they need is written once, in REACH bits.
REACH = 4
PLACE_BITS = 2**REACH - 1
"""Places of this many bits and a sign can be coded."""


def encode_mesh(places: FloatArray, faces: IntArray, bits: int) -> bytes:
    """Return the bytes of a mesh; places: (p, 3) in quantiser steps, most within +-2^(bits - 1); faces: (m, 3).

    A point comes back within half a step along each axis. Faces that share an edge with two others, or disagree
    with their neighbour about the side, come back, too, as seeds of their own. Raises `CapacityError` for places of
    2^PLACE_BITS steps and more.
    """
    walk, out = MeshWalk(bits), Encoder()
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
    mesh = _Encoding(out=out, walk=walk, places=places, reach=reach)
    for seed in sorted(left):
        if seed not in left:
            continue
        left.discard(seed)
        out.symbol(walk.models.more, 0)
        walk.add_face(*(mesh.encode_seed(corner) for corner in seed))
        for a, b, across in walk.next_gates():
            beyond = over.get((mesh.back[a], mesh.back[b]), [])
            face = next((f for f in beyond if _as_set(f, left)), None)
            mesh.encode_gate((a, b, across), face)
            if face is not None:
                left.discard(_as_set(face, left) or face)
                walk.add_face(a, b, mesh.number[face[2]])
    out.symbol(walk.models.more, 1)
    return out.finish()


def _as_set(face: tuple[int, int, int], left: set[tuple[int, ...]]) -> tuple[int, int, int] | None:
    a, b, c = face
    return next((turned for turned in ((a, b, c), (b, c, a), (c, a, b)) if turned in left), None)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Encoding:
    """The encoder's side of a walk.

    places: (p, 3) in quantiser steps; reach: bits of the coordinates of a seed. number: of each point of the mesh
    that was coded, its number in the walk; back: the other way round.
    """

    out: Encoder
    walk: MeshWalk
    places: FloatArray
    reach: int
    number: dict[int, int] = field(default_factory=dict)
    back: list[int] = field(default_factory=list)

    def encode_seed(self, corner: int) -> int:
        """Write a corner of a part's first face, and return its number."""
        out, number = self.out, self.number
        if corner in number:
            out.bits(1, 1)
            out.bits(number[corner], PLAIN)
            return number[corner]
        out.bits(0, 1)
        whole = np.rint(self.places[corner]).astype(int)
        for value in whole:
            out.bits(int(value + (1 << self.reach)), self.reach + 1)
        return self._add(corner, whole.astype(float))

    def encode_gate(self, gate: tuple[int, int, int], face: tuple[int, int, int] | None) -> None:
        """Write what lies across an edge: no face, or one whose third corner is its tip."""
        out, walk, number = self.out, self.walk, self.number
        place, axes = walk.predicted(*gate)
        order, context = walk.ranking(gate[0], gate[1], place)
        kind = walk.models.kind[context]
        if face is None:
            out.symbol(kind, NOTHING)
            return
        tip = face[2]
        if tip not in number:
            out.symbol(kind, NEW)
            off = np.rint(axes @ (self.places[tip] - place)).astype(int)
            for axis, value in enumerate(off):
                _encode_number(out, walk.models, axis, int(value))
            self._add(tip, place + off @ axes)
            return
        out.symbol(kind, KNOWN)
        rank = int(np.argmax(order == number[tip])) if (order == number[tip]).any() else RANKS
        out.symbol(walk.models.rank[context], min(rank, RANKS))
        if rank >= RANKS:
            out.bits(number[tip], PLAIN)

    def _add(self, corner: int, place: FloatArray) -> int:
        self.number[corner] = self.walk.add_point(place)
        self.back.append(corner)
        return self.number[corner]


def _encode_number(out: Encoder, models: WalkModels, axis: int, value: int) -> None:
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
    walk, read = MeshWalk(bits), Decoder(content)
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


def _decode_seed(read: Decoder, walk: MeshWalk, reach: int) -> int:
    if read.bits(1):
        return _known(walk, read.bits(PLAIN))
    return walk.add_point(np.array([float(read.bits(reach + 1) - (1 << reach)) for _ in range(3)]))


def _decode_gate(read: Decoder, walk: MeshWalk, gate: tuple[int, int, int]) -> int | None:
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


def _decode_number(read: Decoder, models: WalkModels, axis: int) -> int:
    length = read.symbol(models.length[axis])
    if not length:
        return 0
    size = 1
    if length > 1:
        size = (1 << (length - 1)) | (read.symbol(models.high[axis][length]) << (length - 2))
        if length > 2:
            size |= read.bits(length - 2)
    return -size if read.bits(1) else size


def _known(walk: MeshWalk, number: int) -> int:
    if number >= walk.count:
        raise InputError("the miniature names a point that it does not have, expected an earlier one")
    return number
