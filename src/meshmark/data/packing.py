"""The hare in few bytes: Draco, without loss but for the order of points and triangles.

Draco codes triangles and points along a walk over the surface, and gives them back in the order of that walk: that
is the order that the hare has. Points are whole numbers of steps of a grid, which Draco keeps as they are; before
its stream stand the lowest corner and the step, as 32-bit floats. Of colours green is kept, and how far red and
blue are from it, modulo 256: what is grey takes next to nothing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["Colours", "Faces", "Points", "packed", "unpacked"]

Points = NDArray[np.float32]
Faces = NDArray[np.int32]
Colours = NDArray[np.uint8]

_SMALLEST = 10  # Draco's slowest setting, with the best compression
_GRID = 4 * 4


def packed(points: Points, faces: Faces, colours: Colours, step: float) -> bytes:
    """Return a mesh in fewer bytes, from which `unpacked` makes the same one in another order.

    points: (n, 3), multiples of `step`, which is a power of two; faces: (m, 3); colours: (n, 3).
    Raises `ValueError` where the mesh would not come back so.
    """
    import DracoPy

    low = points.min(axis=0)
    stream = DracoPy.encode(
        np.rint((points - low) / step).astype(np.uint32),
        faces.astype(np.uint32),
        compression_level=_SMALLEST,
        colors=_apart(colours, 1),
    )
    content: bytes = np.array([*low, step], "<f4").tobytes() + stream
    if _corners(*unpacked(content)) != _corners(points, faces, colours):
        raise ValueError(f"the mesh would not come back as it was, expected steps of {step}")
    return content


def unpacked(content: bytes) -> tuple[Points, Faces, Colours]:
    """Return the points (n, 3), faces (m, 3) and colours (n, 3) of what `packed` made."""
    import DracoPy

    *low, step = np.frombuffer(content[:_GRID], "<f4").tolist()
    mesh = DracoPy.decode(content[_GRID:])
    points = (np.array(low) + step * mesh.points).astype(np.float32)
    return points, mesh.faces.astype(np.int32), _apart(mesh.colors, -1)


def _apart(colours: Colours, sign: int) -> Colours:
    """Return colours (n, 3) with green taken from red and blue, or put back with the sign -1."""
    whole = colours.astype(np.int64)
    whole[:, [0, 2]] -= sign * whole[:, 1:2]
    return (whole % 256).astype(np.uint8)


def _corners(points: Points, faces: Faces, colours: Colours) -> tuple[int, bytes]:
    """Return the number of points, and the places and colours of the faces' corners, whatever their order was."""
    each = np.hstack([points.astype(np.float64), colours])
    _, rank = np.unique(each, axis=0, return_inverse=True)
    rank = rank.ravel()[faces]
    turns = (np.arange(3) + rank.argmin(axis=1)[:, None]) % 3
    corners = each[np.take_along_axis(faces, turns, axis=1)].reshape(len(faces), -1)
    return len(points), corners[np.lexsort(corners.T)].tobytes()
