"""The same for marks at points: what the coordinates of one model's points say of those of another, cube by cube.

The attacker is granted the cubes of every model's lattice, and which coordinates carry. In equal cubes he predicts
the phase of a coordinate by that of another model there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from claims.security.options import KEY, Options
from claims.security.table import Figure
from claims.security.uniformity import uniformity
from meshmark.errors import MeshmarkError
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.ownership.carriers.nodes import find_nodes
from meshmark.ownership.embedding import embed
from meshmark.ownership.ownership_mark import OwnershipMark
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.parameters import SIDE
from meshmark.ownership.points.point_lattice import PointLattice
from meshmark.ownership.points.point_reading import Framed

__all__ = ["Cubes", "cubes_of", "errors_in_cubes", "point_phases"]

POINTS = (60, 1200)
MODELS = 12
MOST_TRIED = 60


@dataclass(frozen=True, eq=False, kw_only=True)
class Cubes:
    """What a model shows of each cube with a point in it: names (k, 3), and turns (k, 3), NaN if none carries."""

    names: IntArray
    turns: FloatArray


def cubes_of(marked: Mesh, mark: OwnershipMark) -> Cubes:
    """Return the phases, in turns, of one point of each cube of the lattice of a mark at points."""
    surface = surface_of(marked)
    lattice = PointLattice.keyed(KEY, mark.label)
    framed = Framed.of(surface, Carried.of(surface, mark.frame), mark.frame, lattice)
    step = mark.step * SIDE
    carries = framed.carrying(framed.best_at(step))
    names, first = np.unique(lattice.cubes(framed.points), axis=0, return_index=True)
    turns = np.where(carries, framed.points / step, np.nan)[first]
    return Cubes(names=names, turns=turns)


def errors_in_cubes(one: Cubes, other: Cubes) -> FloatArray:
    """Return the errors (n,), in turns, of doubled phases that one model predicts of another in equal cubes."""
    row = find_nodes(other.names, one.names)
    errors = 2.0 * (one.turns[row >= 0] - other.turns[row[row >= 0]])
    return np.asarray(errors[np.isfinite(errors)])


def point_phases(options: Options) -> Figure:
    """Mark coarse models at points, and predict each by all before it."""
    small = Options(split=options.split, seed=options.seed, least=POINTS[0], most=POINTS[1], end=options.end)
    found: list[Cubes] = []
    errors = [np.zeros(0)]
    for number, (_, mesh) in enumerate(small.meshes("psb")):
        try:
            made = embed(mesh, KEY, id=number + 1)
        except MeshmarkError:
            continue
        if made.mark.at_points:
            own = cubes_of(made.mesh, made.mark)
            errors += [errors_in_cubes(own, other) for other in found]
            found.append(own)
        if len(found) == options.count(MODELS) or number == MOST_TRIED:
            break
    phases = uniformity(np.concatenate(errors))
    name = "phases of points, predicted by those of other models in the same cubes, poses granted"
    return phases.figure(name, f"{phases.count} coordinates, {len(found)} models")
