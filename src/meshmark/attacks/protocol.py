"""Attacks on the use of marks rather than on one mark: a second mark, collusion, the copy attack.

M. Kutter, S. Voloshynovskiy, A. Herrigel, The watermark copy attack (SPIE 3971, 2000), doi:10.1117/12.384991.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np
from scipy.spatial import cKDTree

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.moved_vertices import moved, moved_points
from meshmark.errors import InputError
from meshmark.geometry.adjacency import mean_squared_edge, unique_edges
from meshmark.geometry.areas import vertex_normals
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.scale_space import discrete_gaussian, random_walk
from meshmark.geometry.surface import Surface
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, Mesh

__all__ = ["collusion", "copy", "second_mark"]

# The copy attack smooths with a Gaussian of this share of the donor's diagonal. On the horse that takes off 0.16 %
# of the diagonal RMS, about as much as a strong mark; twice the width takes off 0.5 %, most of it shape.
SMOOTHING = 0.01


def second_mark(mesh: Mesh, _strength: float, _rng: np.random.Generator, given: Given) -> Attacked:
    """Mark the model again, with `given.embed` and the attacker's own key."""
    embed = cast("Callable[[Mesh], Mesh]", given.embed)  # `Attack.apply` has checked that there is one
    marked = embed(mesh)
    same = len(marked.vertices) == len(mesh.vertices)
    return Attacked(mesh=marked, origin=np.arange(len(mesh.vertices)) if same else None)


def collusion(mesh: Mesh, strength: float, _rng: np.random.Generator, given: Given) -> Attacked:
    """Average the model and the first k - 1 of `given.copies`, vertex by vertex; strength is k.

    Raises `InputError` where there are fewer copies, or one has other faces.
    """
    used = given.copies[: int(strength) - 1]
    if len(used) < strength - 1:
        raise InputError(
            f"collusion of {strength:g} needs {strength - 1:g} other copies and was given {len(used)}"
        )
    for number, other in enumerate(used, 1):
        same = other.vertices.shape == mesh.vertices.shape and np.array_equal(other.faces, mesh.faces)
        if not same:
            raise InputError(
                f"copy {number} has other vertices or faces, expected the same model with another mark"
            )
    return moved(mesh, np.mean([mesh.vertices, *(other.vertices for other in used)], axis=0))


def copy(mesh: Mesh, strength: float, _rng: np.random.Generator, given: Given) -> Attacked:
    """Take what looks like the mark of `given.donor` and put it on this model; strength 1 transfers it in full.

    The estimate is the donor minus its smoothed self, along its normals and over its size. With both models in
    their canonical frames, each point moves along its normal by the estimate at the donor's nearest point.
    """
    donor, target = weld(cast(Mesh, given.donor)), weld(mesh)  # `Attack.apply` has checked that there is one
    source, goal = (canonical_frame(each.points, each.faces) for each in (donor, target))
    _, nearest = cKDTree(source.to_canonical(donor.points)).query(goal.to_canonical(target.points))
    heights = _detail(donor)[nearest] * (strength * goal.scale / source.scale)
    return moved_points(
        mesh, target, target.points + heights[:, None] * vertex_normals(target.points, target.faces)
    )


def _detail(surface: Surface) -> FloatArray:
    """Return (p,): how far each point lies outside the smoothed surface, along its normal."""
    points = surface.points
    edges = unique_edges(surface.faces)
    width = SMOOTHING * np.linalg.norm(np.ptp(points, axis=0))
    alpha = 2.0 * width**2 / mean_squared_edge(points, edges)
    smooth = discrete_gaussian(random_walk(points, edges), points, [alpha])[0]
    heights: FloatArray = np.einsum("ij,ij->i", points - smooth, vertex_normals(points, surface.faces))
    return heights
