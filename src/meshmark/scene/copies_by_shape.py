"""Copies of one mesh in a scene whose file does not say so, found by their shape."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from meshmark.geometry.congruence import Tolerance
from meshmark.geometry.connected import Parts
from meshmark.geometry.copies import Copies, find_copies
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh

__all__ = ["repeated"]

# What may be a copy where the file does not say, each tried in turn: least points of a part, and the tolerance.
# The rounding of an export, and what marks of authentication alone change, lie between the two tolerances.
_EXACT, _NEARLY = Tolerance(0.0, 4e-7), Tolerance(3e-4, 2e-6)
_TRIED: Final = (
    (64, _EXACT, "none"),
    (64, _NEARLY, "none"),
    (8, _EXACT, "none"),
    (8, _NEARLY, "none"),
    (64, _NEARLY, "moved"),
)
_TRIED_TOO: Final = ((64, _EXACT, "cut"), (64, _NEARLY, "cut"))


def repeated(mesh: Mesh, *, cut: bool = False) -> Iterator[Copies]:
    """Yield what may be copies of one mesh in a scene whose file does not say so, by its vertices.

    cut: also of copies that have lost a piece; this takes long.
    """
    surface, seen = surface_of(mesh), list[Copies]()
    first = surface.vertex_of_point
    parts = Parts(surface.points, surface.faces)
    by_vertex = Parts(mesh.vertices, mesh.faces) if len(surface.points) < len(mesh.vertices) else None
    for least, tolerance, edited in (*_TRIED, *(_TRIED_TOO if cut else ())):
        found = find_copies(surface.points, parts, least, tolerance, edited=edited)
        if found is not None:
            point = surface.point_of_vertex
            found = Copies(original=first[found.original[point]], place=found.place[point], maps=found.maps)
        elif by_vertex is not None:
            # Copies may touch, as the halves of a mirrored model do; their vertices distinguish them.
            found = find_copies(mesh.vertices, by_vertex, least, tolerance, edited=edited)
        if found is not None and not any(_same(found, other) for other in seen):
            seen.append(found)
            yield found


def _same(one: Copies, other: Copies) -> bool:
    return bool(((one.place == 0) == (other.place == 0)).all())
