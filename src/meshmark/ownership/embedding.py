"""Embedding of the ownership layer: from a mesh, a key and an id to the marked mesh, read back blind."""

from __future__ import annotations

from contextlib import suppress
from math import sqrt

import numpy as np

from meshmark.coding.keys import Key
from meshmark.coding.message import requested_id
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.surface_of import surface_of_moved
from meshmark.mesh import Mesh
from meshmark.ownership.assembly_parts import assembly_parts
from meshmark.ownership.embedding_in_cells import embed_in_cells
from meshmark.ownership.embedding_task import EmbeddingTask, Owned
from meshmark.ownership.extraction import find
from meshmark.ownership.search.search import Search
from meshmark.strengths import BUDGETS, check_strength
from meshmark.threads import on_one_thread

__all__ = ["Owned", "embed"]

# On models of at most this number of points, points carry rather than cells that dent planes.
SMALL = 5_000
# On models of at most this other number, rather than cells that do not bear noise of this deviation over the
# diagonal, about that of the marks of authentication.
MAY_BE_FRAIL = 20_000
FRAIL_NOISE = 1e-4
# Of the training models tried none tougher than this lost its id to the noise (`OwnershipMark.toughness`), but for
# those of which more than this share is sheets so thin that faces of both sides are in one cell.
FIRM, FOLDED = 0.5, 0.3
# On larger ones planes are left alone where the mark still bears this share of the noise that it would bear; where
# they are more than this share of the surface, it never did on training models.
TOUGH, MOSTLY_PLANE = 0.7, 0.4


@on_one_thread
def embed(
    mesh: Mesh,
    key: Key,
    *,
    id: int | None = None,
    bits: int = 64,
    strength: str = "standard",
    reserve: float = 0.0,
) -> Owned:
    """Put an id into a mesh, as tough as the strength allows.

    The cells of the surface carry it, those that leave planes plane if they are enough, or, where they cannot, as
    on coarse models, its points. Of a few steps, from the one that bears most noise within the budget down, the
    first is taken whose mark, rounded to what the file can hold, is read back blind. Large connected components
    carry it in their points as well, on frames of their own, where the mark of the whole bears that.

    Parameters
    ----------
    mesh : Mesh
    key : Key
    id : int, optional
        Drawn at random where it is left out.
    bits : int
        Of the id: 64, or 32 for models that cannot carry as many; 0: a mark without an id, which says that it is
        there.
    strength : str
        "subtle", "standard" or "strong": visible on about 0.3, 2.5 or 20 % of the surface, with an RMS displacement
        of at most 0.02, 0.08 or 0.2 % of the bounding-box diagonal of the vertices that faces use.
    reserve : float
        RMS over the diagonal that a layer on top of this one needs of the budget.

    Returns
    -------
    Owned

    Raises
    ------
    InputError
        An argument cannot be used.
    CapacityError
        The mesh cannot carry so many bits.
    """
    identity = requested_id(id, bits)
    budget = BUDGETS[check_strength(strength)]
    if not 0.0 <= reserve < budget:
        raise InputError(f"a reserve of {reserve:g} is out of range, expected 0 to the budget {budget:g}")
    task = EmbeddingTask(
        mesh=mesh,
        key=key,
        identity=identity,
        strength=strength,
        rms=sqrt(budget**2 - reserve**2),
    )
    return _with_fingerprint(task)


def _with_fingerprint(task: EmbeddingTask) -> Owned:
    """Return the mark, with a fingerprint beside it where there is room for both."""
    from meshmark.ownership.embedding_with_fingerprint import (
        leaving_room,
        with_fingerprint,
    )

    if not task.may_have_fingerprint:
        return _whole_and_parts(task)
    try:
        owned = _whole_and_parts(leaving_room(task))
    except CapacityError:
        return _whole_and_parts(task)
    return with_fingerprint(task, owned)


def _whole_and_parts(task: EmbeddingTask) -> Owned:
    """Return the mark of the whole, and in those of its parts that can carry it."""
    parts = assembly_parts(task.surface)
    if not parts:
        return _marked(task)
    from meshmark.ownership.embedding_in_parts import embed_in_parts, with_parts_apart

    apart = with_parts_apart(task, parts)
    try:
        owned = _marked(apart)
    except CapacityError:
        if apart is task:
            raise
        owned = _marked(task)
    return embed_in_parts(task, owned, parts)


def _marked(task: EmbeddingTask) -> Owned:
    """Return the mark in cells beside the plane parts, in all cells, or in points, whichever suits the surface."""
    small = len(task.surface.points) <= SMALL
    flat = _beside_planes(task) if small or task.planes.share <= MOSTLY_PLANE else None
    if flat is not None and small and not _is_frail(task, flat):
        return flat
    try:
        in_cells = embed_in_cells(task)
    except CapacityError as error:
        try:
            return _in_points(task)
        except CapacityError as other:
            raise CapacityError(f"{error}; {other}") from None
    leaves_planes = flat is not None and not small and flat.mark.toughness >= TOUGH * in_cells.mark.toughness
    if flat is not None and leaves_planes and not _is_frail(task, flat):
        return flat
    bears = (not small or task.keeps_planes(in_cells.mesh)) and not _is_frail(task, in_cells)
    if not bears:
        with suppress(CapacityError):
            in_points = _in_points(task)
            if small or not _is_frail(task, in_points):
                return in_points
    return in_cells


def _beside_planes(task: EmbeddingTask) -> Owned | None:
    """Return a mark in cells that leaves plane parts alone, None where there are none or too little beside them."""
    if not task.has_planes:
        return None
    try:
        flat = embed_in_cells(task, still=task.planes.points)
    except CapacityError:
        return None
    return flat if task.keeps_planes(flat.mesh) else None


def _in_points(task: EmbeddingTask) -> Owned:
    from meshmark.ownership.embedding_in_points import embed_in_points

    return embed_in_points(task)


def _is_frail(task: EmbeddingTask, made: Owned) -> bool:
    """Return whether the mark of a small model bears so little that a layer on top takes the id away."""
    firm = not made.mark.at_points and made.mark.toughness > FIRM and made.folded <= FOLDED
    if firm or len(task.surface.points) > MAY_BE_FRAIL:
        return False
    size = task.surface.points.shape
    rng = np.random.default_rng(0)  # the same noise every time
    noise = FRAIL_NOISE * task.diagonal * rng.normal(size=size)
    surface = surface_of_moved(made.mesh, task.mesh)
    search = Search(surface=surface.moved(surface.points + noise), key=task.key, effort="plain")
    return find(search).id != task.identity
