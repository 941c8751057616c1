"""A model's surface in a given number of bytes, in canonical coordinates (docs/design.md, section 8)."""

from __future__ import annotations

import numpy as np

from meshmark.errors import CapacityError, InputError
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.areas import face_areas
from meshmark.geometry.components import connected_components
from meshmark.geometry.frame import Frame, canonical_frame
from meshmark.mesh import FloatArray, IntArray
from meshmark.recovery.mesh_coder import PLACE_BITS, decode_mesh, encode_mesh
from meshmark.recovery.simplify import simplify

__all__ = ["SMALLEST", "miniature", "read_miniature"]

SMALLEST = 40
"""Bytes of the smallest miniature that is made."""
LARGEST_POINTS = 4000
# Bits of a point in a miniature, connections included: the first guess, and how often it is corrected.
BITS_OF_POINT, TRIES = 12.0, 10
# Quantiser steps along the RMS size of a surface, for each of its points: rounding is to be about what
# simplification changes, which falls as their number grows. Measured: docs/decisions/0007.
STEPS_OF_POINT = 0.12
BITS = (4, 13)


def miniature(points: FloatArray, faces: IntArray, size_bytes: int, *, frame: Frame | None = None) -> bytes:
    """Return the surface in at most `size_bytes` bytes, in the canonical coordinates of its own frame.

    Of many parts that do not fit the smallest are left out. points: (p, 3); faces: (m, 3);
    frame: the surface's canonical frame, where it is known already. Raises `CapacityError`
    where the bytes are too few even for a crude shape, `InputError` where there is no surface.
    """
    canonical = (frame or canonical_frame(points, faces)).to_canonical(points)
    count = min(int(8 * size_bytes / BITS_OF_POINT), LARGEST_POINTS)
    best = None
    few, small = simplify(canonical, faces, max(count, 4)) if size_bytes >= SMALLEST else (canonical, faces)
    for _ in range(TRIES):
        if size_bytes < SMALLEST or not len(small):
            break
        content = _encoded(few, small)
        if len(content) <= size_bytes:
            best = content
            break
        count = max(int(len(few) * min(0.97, size_bytes / len(content))), 4)
        few, small = simplify(few, small, count)
        if len(few) > 1.03 * count:  # parts that cannot get simpler: the smallest go
            few, small = _largest_parts(few, small, count)
    if best is None:
        raise CapacityError(
            f"a miniature of the model does not fit the {size_bytes} bytes that the model has room for"
        )
    return best


def _largest_parts(points: FloatArray, faces: IntArray, count: int) -> tuple[FloatArray, IntArray]:
    """Return the connected parts of most area, about `count` points in all, at least one part."""
    part = connected_components(adjacency(unique_edges(faces), len(points)))[1]
    area = np.bincount(part[faces[:, 0]], face_areas(points, faces), part.max() + 1)
    order = np.argsort(-area, kind="stable")
    kept = order[: max(int((np.cumsum(np.bincount(part)[order]) <= count).sum()), 1)]
    stays = np.isin(part, kept)
    number = np.cumsum(stays) - 1
    return points[stays], number[faces[stays[faces[:, 0]]]]


def _encoded(points: FloatArray, faces: IntArray) -> bytes:
    low, high = BITS
    # Parts far away must stay within the coder's reach: |place| * 2^(bits - 1) <= 2^PLACE_BITS.
    largest = float(np.abs(points).max(initial=1.0))
    high = max(min(high, PLACE_BITS + 1 - int(np.ceil(np.log2(largest)))), low)
    bits = int(np.clip(np.ceil(np.log2(STEPS_OF_POINT * max(len(points), 1)) + 1.0), low, high))
    return bytes([bits]) + encode_mesh(points * 2.0 ** (bits - 1), faces, bits)


def read_miniature(content: bytes) -> tuple[FloatArray, IntArray]:
    """Return points (p, 3) and faces (m, 3) in canonical coordinates; raises `InputError` for damaged content."""
    if not content or not BITS[0] <= content[0] <= BITS[1]:
        raise InputError("the bytes are no miniature, expected one that meshmark made")
    bits = content[0]
    places, faces = decode_mesh(content[1:], bits)
    if not len(faces):
        raise InputError("the miniature has no faces, expected a surface")
    return places / 2.0 ** (bits - 1), faces
