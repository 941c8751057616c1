"""Embedding of the ownership layer: from a mesh, a key and an id to the marked mesh, read back blind."""

from __future__ import annotations

from math import sqrt

from meshmark.coding.keys import Key
from meshmark.coding.message import check_id, random_id
from meshmark.errors import CapacityError, InputError
from meshmark.mesh import Mesh
from meshmark.ownership.embedding_in_cells import embed_in_cells
from meshmark.ownership.embedding_task import EmbeddingTask, Owned
from meshmark.strengths import BUDGETS, check_strength
from meshmark.threads import on_one_thread

__all__ = ["Owned", "embed"]


@on_one_thread
def embed(
    mesh: Mesh, key: Key, *, id: int | None = None, strength: str = "standard", reserve: float = 0.0
) -> Owned:
    """Put a 64-bit id into a mesh, as tough as the strength allows.

    The cells of the surface carry it, or, where they cannot, as on coarse models, its points. Of a few steps, from
    the one that bears most noise within the budget down, the first is taken whose mark, rounded to what the file
    can hold, is read back blind.

    Parameters
    ----------
    mesh : Mesh
    key : Key
    id : int, optional
        64 bits; drawn at random where it is left out.
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
        The mesh cannot carry 64 bits.
    """
    identity = random_id() if id is None else check_id(id)
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
    try:
        return embed_in_cells(task)
    except CapacityError as error:
        from meshmark.ownership.embedding_in_points import embed_in_points

        try:
            return embed_in_points(task)
        except CapacityError as other:
            raise CapacityError(f"{error}; {other}") from None
