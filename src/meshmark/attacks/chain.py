"""Attacks one after the other, written "crop:0.1+noise:0.003+similarity"."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from meshmark.attacks.attack import Attacked, Given, Need
from meshmark.attacks.table import find_attack
from meshmark.errors import InputError
from meshmark.mesh import IntArray, Mesh

__all__ = ["NOTHING", "Chain", "parse_chain"]

# The text of the chain without a step.
NOTHING = "none"
# A plus between steps stands before a name; one inside a number (1e+3) does not.
_JOINT = re.compile(r"\+(?=\s*[A-Za-z_])")


@dataclass(frozen=True)
class Chain:
    """Attacks to be made in order, each a name in `ATTACKS` and a strength; `str` gives the one text form.

    Raises `InputError` for an unknown name or a strength that the attack does not take.
    """

    steps: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        for name, strength in self.steps:
            try:
                find_attack(name).check(strength)
            except InputError as error:
                raise type(error)(f"{name}: {error}" if name not in str(error) else str(error)) from None

    def __str__(self) -> str:
        """Return "name:strength+..." with every strength, shortest digits; "none" without a step."""
        return "+".join(f"{name}:{_shortest(strength)}" for name, strength in self.steps) or NOTHING

    @property
    def needs(self) -> frozenset[Need]:
        """Return what of `Given` the steps cannot do without."""
        return frozenset(find_attack(name).needs for name, _ in self.steps) - {""}

    def __call__(self, mesh: Mesh, rng: np.random.Generator, given: Given | None = None) -> Mesh:
        """Return the attacked mesh; see `apply`."""
        return self.apply(mesh, rng, given).mesh

    def apply(self, mesh: Mesh, rng: np.random.Generator, given: Given | None = None) -> Attacked:
        """Make all attacks in order, with the maps of all of them combined.

        The first step draws from `rng` itself, as the attack alone would; each later one from a stream of its
        own, spawned from `rng`, so that no step depends on how much an earlier one drew.
        Where a step after a local edit has no map, a vertex counts as altered where the nearest vertex before
        that step did. Raises what `Attack.apply` raises.
        """
        streams = [rng, *rng.spawn(max(len(self.steps) - 1, 0))]
        result = Attacked(mesh=mesh, origin=np.arange(len(mesh.vertices)))
        for (name, strength), stream in zip(self.steps, streams, strict=False):
            step = find_attack(name).apply(result.mesh, strength, stream, given)
            result = _combined(result, step)
        return result


def parse_chain(text: str) -> Chain:
    """Read a chain such as "crop:0.1+noise:0.003+similarity", or "none".

    Parameters
    ----------
    text : str
        Steps joined by plus signs, each a key of `ATTACKS` and, after a colon, a strength. A step without a
        strength takes the attack's default, the middle of its strengths in the table.

    Returns
    -------
    Chain
        The steps in order; none for "none".

    Raises
    ------
    InputError
        A name is unknown, or a strength is no number or not one that the attack takes.
    """
    if text.strip() == NOTHING:
        return Chain()
    return Chain(tuple(_parse_step(step.strip()) for step in _JOINT.split(text)))


def _parse_step(step: str) -> tuple[str, float]:
    name, colon, number = step.partition(":")
    attack = find_attack(name)
    if not colon:
        return name, attack.default
    try:
        return name, float(number)
    except ValueError:
        raise InputError(f"'{step}' has the strength '{number}', expected a number") from None


def _shortest(strength: float) -> str:
    return str(int(strength)) if strength == int(strength) else repr(float(strength))


def _combined(before: Attacked, step: Attacked) -> Attacked:
    """Return the maps from the very first mesh to the last one."""
    return Attacked(
        mesh=step.mesh, origin=_origin(before.origin, step.origin), altered=_altered(before, step)
    )


def _origin(before: IntArray | None, step: IntArray | None) -> IntArray | None:
    if before is None or step is None:
        return None
    origin = step.copy()
    origin[step >= 0] = before[step[step >= 0]]
    return origin


def _altered(before: Attacked, step: Attacked) -> NDArray[np.bool_] | None:
    if before.altered is None:
        return step.altered
    count = len(step.mesh.vertices)
    origin = np.full(count, -1) if step.origin is None else step.origin
    new = np.flatnonzero(origin < 0)
    carried = before.altered[origin]
    if step.altered is None:
        _, nearest = cKDTree(before.mesh.vertices).query(step.mesh.vertices[new])
        carried[new] = before.altered[nearest]
        return carried
    carried[new] = False
    return carried | step.altered
