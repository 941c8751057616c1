"""What adding to a marked model, in its parts or beside its cells, may cost: the mark, the budget, the look."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from meshmark.geometry.surface_of import surface_of_moved
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership.embedding_task import EmbeddingTask, Owned
from meshmark.ownership.extraction import find
from meshmark.ownership.search.search import Search
from meshmark.ownership.vertex_displacement import displacement_rms

__all__ = ["MarkLeft", "points_of"]

# How much of the lock of the mark must be left.
LEFT = 0.9
# What may be added to the visible share, over that which is allowed, where the caller does not say.
SEEN_MORE = 0.1


@dataclass(frozen=True, eq=False, kw_only=True)
class MarkLeft:
    """The limits of what is added to `owned`, the mark of the task's model.

    seen_more: what may be added to the visible share, over that which is allowed.
    """

    task: EmbeddingTask
    owned: Owned
    seen_more: float = SEEN_MORE

    @cached_property
    def _seen(self) -> float:
        share = self.task.seen.of(points_of(self.task, self.owned.mesh)).share
        return max(self.task.share, share) + self.seen_more * self.task.share

    @cached_property
    def _lock(self) -> float:
        return _lock(self.task, self.owned)

    def enough_in(self, made: Owned) -> bool:
        """Return whether a mesh with more in it keeps the mark, the budget, plane parts, and shows little more."""
        task = self.task
        return (
            displacement_rms(task.mesh, made.mesh) <= task.budget
            and task.seen.of(points_of(task, made.mesh)).share <= self._seen
            and (task.keeps_planes(made.mesh) or not task.keeps_planes(self.owned.mesh))
            and _lock(task, made) >= LEFT * self._lock
        )


def points_of(task: EmbeddingTask, mesh: Mesh) -> FloatArray:
    """Return the points (p, 3) of the task's surface as a mesh of the same vertices has them."""
    return mesh.vertices[task.surface.vertex_of_point]


def _lock(task: EmbeddingTask, owned: Owned) -> float:
    """Return the mean cosine of the phases of the mark of the whole, 0 where it is not read."""
    search = Search(
        surface=surface_of_moved(owned.mesh, task.mesh),
        key=task.key,
        effort="plain",
        label=owned.mark.label,
        spacings=() if owned.mark.at_points else (owned.mark.spacing,),
    )
    found = find(search)
    if found.id != task.identity or found.reading is None:
        return 0.0
    return found.reading.score / float(found.reading.keys.weight.sum())
