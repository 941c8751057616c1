"""Which parts of a marked model tell the id by themselves, once all layers are in it."""

from __future__ import annotations

from meshmark.coding.keys import Key
from meshmark.geometry.surface import Surface
from meshmark.mesh import Mesh
from meshmark.ownership.parts_read import part_surfaces, parts_at_points

__all__ = ["parts_in_words", "parts_read", "tells_id"]


def parts_read(mesh: Mesh, key: Key, identity: int, carrying: tuple[int, ...]) -> tuple[tuple[int, ...], int]:
    """Return which parts of a marked mesh still carry the id in their points, and how many tell it in some layer.

    Parameters
    ----------
    mesh : Mesh
        With all its layers.
    key : Key
    identity : int
        The id, as `coding.message` counts it.
    carrying : tuple of int
        Numbers, among the `assembly_parts` of the surface, of those in whose points the id was put.

    Returns
    -------
    tuple of int, int
        Those of `carrying` from whose points it is read, and the number of parts that tell it by their points or
        by their marks of authentication.
    """
    surfaces = part_surfaces(mesh)
    at_points = parts_at_points(surfaces, carrying, key, identity)
    others = (part for number, part in enumerate(surfaces) if number not in at_points and part is not None)
    return at_points, len(at_points) + sum(_is_read_in_marks(part, key, identity) for part in others)


def tells_id(part: Surface, key: Key, identity: int) -> bool:
    """Return whether the id is surely read from a part's surface, in its points or its marks of authentication."""
    from meshmark.ownership.embedding_in_parts import is_read_in_part

    return _is_read_in_marks(part, key, identity) or is_read_in_part(part, key, identity)


def _is_read_in_marks(part: Surface, key: Key, identity: int) -> bool:
    """Return whether this id, and no other, is surely read from a part's marks of authentication."""
    from meshmark.authentication.checks.marked_ids import marked_ids
    from meshmark.ownership.embedding_in_parts import SURE

    found = marked_ids(part, key)
    return [each.id for each in found] == [identity] and found[0].log10_chance <= SURE


def parts_in_words(count: int, bits: int) -> tuple[str, ...]:
    """Return a remark about so many parts that tell the id, of this number of bits, by themselves; none of none."""
    if not count:
        return ()
    what = "id" if bits else "mark"
    if count == 1:
        return (f"one part carries the {what} by itself as well, and tells it when it is taken out",)
    return (f"{count} parts carry the {what} by themselves as well, and tell it when they are taken out",)
