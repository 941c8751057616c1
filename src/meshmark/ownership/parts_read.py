"""Which parts of a marked model carry the id by themselves, once all layers are in it."""

from __future__ import annotations

from dataclasses import replace

from meshmark.coding.keys import Key
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.ownership.ownership_mark import OwnershipMark

__all__ = ["with_parts_read"]


def with_parts_read(mark: OwnershipMark, mesh: Mesh, key: Key, identity: int) -> OwnershipMark:
    """Return the mark with those of its parts from whose points the id is read in this mesh."""
    if not mark.parts:
        return mark
    from meshmark.ownership.assembly_parts import assembly_parts
    from meshmark.ownership.embedding_in_parts import is_read_in_part

    whole = surface_of(mesh)
    parts = assembly_parts(whole)
    surfaces = {number: parts[number].surface(whole.points) for number in mark.parts if number < len(parts)}
    told = (n for n, part in surfaces.items() if part is not None and is_read_in_part(part, key, identity))
    return replace(mark, parts=tuple(told))
