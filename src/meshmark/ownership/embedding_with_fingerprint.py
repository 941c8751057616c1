"""Embedding of the fingerprint: points that do not carry slide along the surface until they say the id once more.

Where their bits are the same the points of all copies of a model go to the same places: those nearest to where
the original has them, by a step that depends on the strength only. So an average keeps what copies have in common.
"""

from __future__ import annotations

from dataclasses import replace

from meshmark.coding.codec import Codec
from meshmark.geometry.surface_of import surface_of_moved
from meshmark.ownership.carrying_points import carrying_points
from meshmark.ownership.embedding_task import EmbeddingTask, Owned
from meshmark.ownership.fingerprint.parameters import (
    LARGEST_SHARE,
    RESERVED,
    choice_of,
)
from meshmark.ownership.fingerprint.roles import Said, fingerprint_lattice
from meshmark.ownership.mark_left import MarkLeft
from meshmark.ownership.parts_read import part_surfaces, parts_at_points
from meshmark.ownership.points.parameters import LARGEST
from meshmark.ownership.points.point_shaping import PointShaping

__all__ = ["leaving_room", "with_fingerprint"]

# What points that slide may add to the visible share, over that which is allowed. They add a fifteenth or take it
# away; a copy that has no fingerprint leaves those untold that it is put together with.
SEEN_MORE = 0.3


def leaving_room(task: EmbeddingTask) -> EmbeddingTask:
    """Return the task with the budget that the cells have beside a fingerprint."""
    return replace(task, rms=task.rms * (1.0 - RESERVED**2) ** 0.5)


def with_fingerprint(task: EmbeddingTask, owned: Owned) -> Owned:
    """Return a marked mesh with a fingerprint besides; as it is where that costs the mark too much.

    Parameters
    ----------
    task : EmbeddingTask
        Of the unmarked mesh, with the whole budget.
    owned : Owned
        The mark in cells, or in points: those that carry it stay where they are.
    """
    surface = surface_of_moved(owned.mesh, task.mesh)
    if len(surface.points) != len(task.surface.points):
        return owned
    carrying = carrying_points(task, owned)
    shaping = PointShaping(
        surface,
        fingerprint_lattice(task.key, owned.mark.label),
        Said.of(Codec(task.key), task.identity),
        largest=LARGEST_SHARE * LARGEST[task.strength],
        budget=0.0,
        still=carrying if owned.held is None else owned.held | carrying,
        holds_area=True,
        aims=task.surface.points,
    )
    points = shaping.shaped(choice_of(task.strength))
    if points is None:
        return owned
    made = replace(owned, mesh=task.moved(points))
    left = MarkLeft(task=task, owned=owned, seen_more=SEEN_MORE)
    return made if left.enough_in(made) and _parts_are_read(task, made) else owned


def _parts_are_read(task: EmbeddingTask, made: Owned) -> bool:
    """Return whether the parts that carry the id by themselves still do."""
    parts = made.mark.parts
    return not parts or parts_at_points(part_surfaces(made.mesh), parts, task.key, task.identity) == parts
