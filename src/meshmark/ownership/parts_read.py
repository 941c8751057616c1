"""Which parts of a marked model carry the id by themselves, once all layers are in it."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from meshmark.coding.keys import Key
from meshmark.geometry.surface import Surface
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh

__all__ = ["part_surfaces", "parts_at_points"]


def part_surfaces(mesh: Mesh) -> list[Surface | None]:
    """Return the surface of each of a mesh's `assembly_parts` by itself, None where it has none."""
    from meshmark.ownership.assembly_parts import assembly_parts

    whole = surface_of(mesh)
    return [part.surface(whole.points) for part in assembly_parts(whole)]


def parts_at_points(
    surfaces: Sequence[Surface | None], carrying: Collection[int], key: Key, identity: int
) -> tuple[int, ...]:
    """Return the numbers, among those of `carrying`, of the parts from whose points the id is read."""
    from meshmark.ownership.embedding_in_parts import is_read_in_part

    return tuple(
        number
        for number, part in enumerate(surfaces)
        if number in carrying and part is not None and is_read_in_part(part, key, identity)
    )
