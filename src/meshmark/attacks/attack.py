"""What an attack is: a function from a mesh and a strength to the attacked mesh and what became of its vertices."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import InputError
from meshmark.mesh import IntArray, Mesh

__all__ = ["Attack", "Attacked", "Function", "Given", "Need"]

Function = Callable[[Mesh, float, np.random.Generator, "Given"], "Attacked"]
Need = Literal["", "copies", "donor", "embed"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Attacked:
    """An attacked mesh of n vertices.

    origin:  (n,) the number that each vertex had before the attack, -1 for one that is new; None where the
             attack makes a new surface and no such map exists.
    altered: (n,) whether a local edit moved or made the vertex, the truth that a tamper map is judged by;
             None for attacks on the whole model.
    """

    mesh: Mesh
    origin: IntArray | None
    altered: NDArray[np.bool_] | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Given:
    """What an attacker may hold besides the model.

    copies: the same model with other marks (collusion); donor: another marked model (copy attack, paste);
    embed:  marks a mesh with a key of the attacker's own (second mark).
    """

    copies: tuple[Mesh, ...] = ()
    donor: Mesh | None = None
    embed: Callable[[Mesh], Mesh] | None = None


@dataclass(frozen=True, kw_only=True)
class Attack:
    """One kind of attack; `attack(mesh, strength, rng)` returns the attacked mesh.

    strengths: those of the benchmark, mildest first; strength 0 always changes nothing.
    unit:      what a strength counts.
    imitates:  the common edit or damage that this stands for.
    needs:     what of `Given` it cannot do without.
    lowest, highest, whole: the strengths other than 0 that it takes; whole numbers only, or all between.
    """

    function: Function = field(repr=False)
    strengths: tuple[float, ...]
    unit: str
    imitates: str
    needs: Need = ""
    lowest: float = 0.0
    highest: float = inf
    whole: bool = False

    @property
    def default(self) -> float:
        """Return the middle one of `strengths` (of an even number, the milder of the two in the middle)."""
        return self.strengths[(len(self.strengths) - 1) // 2]

    def check(self, strength: float) -> None:
        """Raise `InputError` for a strength that the attack does not take."""
        if strength == 0.0:
            return
        inside = isfinite(strength) and self.lowest <= strength <= self.highest and strength > 0.0
        if not inside or (self.whole and strength != int(strength)):
            raise InputError(f"strength {strength:g} is out of range, expected 0 or {self._range()}")

    def _range(self) -> str:
        kind = "a whole number" if self.whole else "a number"
        if self.highest == self.lowest:
            return f"{self.lowest:g} ({self.unit})"
        upper = "" if self.highest == inf else f" to {self.highest:g}"
        if self.lowest == 0.0:
            return f"{kind} above 0{upper and f', up{upper}'} ({self.unit})"
        return f"{kind} from {self.lowest:g}{upper or ' upwards'} ({self.unit})"

    def __call__(
        self, mesh: Mesh, strength: float, rng: np.random.Generator, given: Given | None = None
    ) -> Mesh:
        """Return the attacked mesh; see `apply`."""
        return self.apply(mesh, strength, rng, given).mesh

    def apply(
        self, mesh: Mesh, strength: float, rng: np.random.Generator, given: Given | None = None
    ) -> Attacked:
        """Attack a mesh, which stays as it is; the same generator state gives the same result.

        Parameters
        ----------
        mesh : Mesh
            The model, at least one vertex.
        strength : float
            0, which changes nothing, or a strength that `check` accepts, in `unit`.
        rng : numpy.random.Generator
            Source of all that is random.
        given : Given, optional
            What the attacker holds besides the model; `needs` says what is required.

        Returns
        -------
        Attacked
            The attacked mesh, and where its vertices came from.

        Raises
        ------
        InputError
            The attack does not take this strength or cannot work on this mesh, or `given` lacks what it needs.
        """
        self.check(strength)
        if strength == 0.0:
            return Attacked(mesh=mesh, origin=np.arange(len(mesh.vertices)))
        held = given or Given()
        if self.needs and not getattr(held, self.needs):
            raise InputError(_MISSING[self.needs])
        if not len(mesh.vertices):
            raise InputError("the model has no vertices, expected at least one to attack")
        return self.function(mesh, strength, rng, held)


_MISSING = {
    "copies": "this attack averages copies of the model with other marks, expected at least one more copy",
    "donor": "this attack takes from another marked model, expected one",
    "embed": "this attack marks the model a second time, expected an embedder (or use `meshmark embed`)",
}
