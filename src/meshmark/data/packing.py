"""The hare in few bytes: Draco, without loss, with the order of the points beside it.

Draco codes triangles and points along a walk over the surface, which takes far less than their own order does, and
gives them back in the order of that walk. So the place of each point in the original is an attribute of its own;
the faces need none, since they are kept sorted. Points are whole numbers of steps of a grid, which Draco keeps as
they are; before its stream stand the lowest corner and the step, as 32-bit floats. Of colours green is kept, and
how far red and blue are from it, modulo 256: what is grey takes next to nothing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["Colours", "Faces", "Points", "packed", "sorted_faces", "unpacked"]

Points = NDArray[np.float32]
Faces = NDArray[np.int32]
Colours = NDArray[np.uint8]

_ORDER = "order"
_SMALLEST = 10  # Draco's slowest setting, with the best compression
_GRID = 4 * 4


def packed(points: Points, faces: Faces, colours: Colours, step: float) -> bytes:
    """Return a mesh in fewer bytes, from which `unpacked` makes the same one to the bit.

    points: (n, 3), multiples of `step`, which is a power of two; faces: (m, 3), in the order of `sorted_faces`;
    colours: (n, 3). Raises `ValueError` where the mesh would not come back so.
    """
    import DracoPy

    low = points.min(axis=0)
    stream = DracoPy.encode(
        np.rint((points - low) / step).astype(np.uint32),
        faces.astype(np.uint32),
        compression_level=_SMALLEST,
        colors=_apart(colours, 1),
        generic_attributes={_ORDER: np.arange(len(points), dtype=np.uint32)[:, None]},
    )
    content: bytes = np.array([*low, step], "<f4").tobytes() + stream
    if [array.tobytes() for array in unpacked(content)] != [
        array.tobytes() for array in (points, faces, colours)
    ]:
        raise ValueError(f"the mesh would not come back as it was, expected steps of {step} and sorted faces")
    return content


def unpacked(content: bytes) -> tuple[Points, Faces, Colours]:
    """Undo `packed`: points (n, 3), faces (m, 3), colours (n, 3)."""
    import DracoPy

    *low, step = np.frombuffer(content[:_GRID], "<f4").tolist()
    mesh = DracoPy.decode(content[_GRID:])
    order = mesh.get_attribute_by_name(_ORDER)["data"].ravel()
    back = np.argsort(order)
    points = (np.array(low) + step * mesh.points[back]).astype(np.float32)
    return points, sorted_faces(order[mesh.faces].astype(np.int32)), _apart(mesh.colors[back], -1)


def _apart(colours: Colours, sign: int) -> Colours:
    """Return colours (n, 3) with green taken from red and blue, or put back with the sign -1."""
    whole = colours.astype(np.int64)
    whole[:, [0, 2]] -= sign * whole[:, 1:2]
    return (whole % 256).astype(np.uint8)


def sorted_faces(faces: Faces) -> Faces:
    """Return the faces (m, 3) in order, each turned so that its lowest corner comes first."""
    turns = (np.arange(3) + faces.argmin(axis=1)[:, None]) % 3
    turned: Faces = np.take_along_axis(faces, turns, axis=1)
    return turned[np.lexsort(turned.T[::-1])]
