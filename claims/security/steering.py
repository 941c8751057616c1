"""A lattice that is known from one model, forged on another that is warped until it has the same label.

What takes a shape to the coordinates that its label is made of is public; only the edges of the bins are keyed. An
attacker who holds an original and its marked copy can therefore warp an unmarked model until it has that model's
coordinates, and so its label and its lattice. What he lacks is what the key says of cells that the donor did not
have. So he does it the more easily the nearer the model is to the donor: how near is measured on the donor's own
original, warped at random before.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice
from time import monotonic

import numpy as np

from claims.security.donors import Donor, donors, forged, learnt, measured
from claims.security.options import KEY, Options
from claims.security.table import Figure
from meshmark.errors import MeshmarkError
from meshmark.geometry.invariants import shape_invariants
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership.carriers.lattice_label import Label, shipped_map
from meshmark.ownership.extraction import extract

__all__ = ["Steered", "forged_on", "label_coordinates", "steered", "steering", "warped"]

MODELS, NEAR_MODELS = 12, 4
SIZES = (0.02, 0.04, 0.08, 0.16)
"""Random warps, RMS over the diagonal."""
# Newton steps at most; a coordinate that is off by less, in bins, is near enough; change of a warp's weight for
# slopes; bins that one step covers.
STEPS, NEAR, SLOPE, STRIDE = 14, 0.03, 1e-3, 1.0
# Warps are of monomials of canonical coordinates up to this degree; higher ones are weighed down.
DEGREE = 3


@dataclass(frozen=True, eq=False, kw_only=True)
class Steered:
    """A warped model; moved: RMS displacement over the diagonal; off: largest error of a coordinate, in bins."""

    mesh: Mesh
    moved: float
    off: float


def label_coordinates(mesh: Mesh) -> FloatArray:
    """Return the coordinates (6,) that a shape's label is made of, in bins."""
    return surface_of(mesh).invariants @ shipped_map().matrix


def steered(target: Mesh, wanted: FloatArray) -> Steered:
    """Return the target warped as little as it takes until it has the wanted coordinates (6,)."""
    surface = surface_of(target)
    start = surface.frame.to_canonical(surface.points)
    warps = _warps(start)
    weights = np.zeros(len(warps))

    def coordinates(values: FloatArray) -> FloatArray:
        points = start + np.tensordot(values, warps, axes=1)
        return shape_invariants(points, surface.faces) @ shipped_map().matrix

    found = coordinates(weights)
    for _ in range(STEPS):
        if np.abs(found - wanted).max() < NEAR:
            break
        slopes = [(coordinates(weights + SLOPE * row) - found) / SLOPE for row in np.eye(len(warps))]
        gap = wanted - found
        gap *= min(1.0, STRIDE / np.abs(gap).max())
        weights = weights + np.linalg.lstsq(np.array(slopes).T, gap, rcond=1e-6)[0]
        found = coordinates(weights)
    moved = np.tensordot(weights, warps, axes=1)
    points = surface.frame.to_scene(start + moved)
    size = float(np.sqrt((moved**2).sum(axis=1).mean())) * surface.frame.scale / surface.diagonal
    return Steered(
        mesh=target.with_vertices(points[surface.point_of_vertex]),
        moved=size,
        off=float(np.abs(found - wanted).max()),
    )


def steering(options: Options) -> list[Figure]:
    """Return what comes of it on other models, and on warped copies of the donors' own originals."""
    return [_on_others(options), *_on_warped(options)]


def forged_on(target: Mesh, donor: Donor) -> tuple[Steered, Mesh]:
    """Return the target with the donor's label, and that with what was learnt of the donor's mark."""
    made = steered(target, label_coordinates(donor.marked))
    return made, forged(made.mesh, learnt(donor), donor.mark.step)


def _on_warped(options: Options) -> list[Figure]:
    present: dict[float, list[bool]] = {size: [] for size in SIZES}
    for row, donor in enumerate(islice(donors(options), min(NEAR_MODELS, options.count(NEAR_MODELS)))):
        rng = options.rng(30, row)
        for size in SIZES:
            if monotonic() > options.end:
                break
            made, suspect = forged_on(warped(donor.original, size, rng), donor)
            said = extract(suspect, KEY, search="plain")
            present[size].append(said.presence == "present")
            print(
                f"{donor.name}, warped by {size:.0%}: moved by {made.moved:.2%} more, {said.presence}",
                flush=True,
            )
    return [
        Figure(
            name=f"a donor's own original, warped by {size:.0%}, then to the donor's label: present",
            measured=str(sum(said)),
            of=f"{len(said)} forgeries",
        )
        for size, said in present.items()
    ]


def warped(mesh: Mesh, size: float, rng: np.random.Generator) -> Mesh:
    """Return a mesh moved by a random smooth warp of this RMS size over the diagonal."""
    surface = surface_of(mesh)
    warps = _warps(surface.frame.to_canonical(surface.points))
    moved = np.tensordot(rng.normal(size=len(warps)), warps, axes=1) @ surface.frame.axes.T
    moved *= size * surface.diagonal / np.sqrt((moved**2).sum(axis=1).mean())
    return mesh.with_vertices((surface.points + moved)[surface.point_of_vertex])


def _on_others(options: Options) -> Figure:
    models = list(options.meshes("models"))
    places = np.array([label_coordinates(mesh) for _, mesh in models])
    same = present = 0
    tried: list[str] = []
    moved: list[float] = []
    for row, (name, mesh) in enumerate(models[: options.count(MODELS)]):
        apart = np.linalg.norm(places - places[row], axis=1)
        apart[row] = np.inf
        donor_name, original = models[int(apart.argmin())]
        try:
            donor = Donor.of(donor_name, original, row + 1)
        except MeshmarkError:
            continue
        if donor.mark.at_points or monotonic() > options.end:
            continue
        made, suspect = forged_on(mesh, donor)
        lattice = learnt(donor)
        has_label = Label.of_shape(surface_of(suspect).invariants, KEY) == donor.mark.label
        nodes = measured(suspect, lattice).cells.nodes
        said = extract(suspect, KEY, search="plain")
        same, present = same + has_label, present + (said.presence == "present")
        moved.append(made.moved)
        tried.append(name)
        print(
            f"{name} as {donor_name}: moved by {100 * made.moved:.1f} %, off {made.off:.3f}, same label "
            f"{has_label}, {lattice.knows(nodes)} of {len(nodes)} cells known, {said.presence}, "
            f"10^{said.log10_false_positive:.1f}",
            flush=True,
        )
    size = f"{100 * np.median(moved):.1f} %" if moved else "-"
    return Figure(
        name="models warped to a donor's label: label reached, forged mark present",
        measured=f"{same}, {present}; warped by {size} of the diagonal",
        of=f"{len(tried)} forgeries",
        bar="0 present",
        met=present == 0,
    )


def _warps(points: FloatArray) -> FloatArray:
    """Return displacements (k, p, 3), each of RMS about 1 over its degree: monomials along each axis."""
    x, y, z = (np.tanh(points) * 1.3).T
    found = []
    for one in range(DEGREE + 1):
        for two in range(DEGREE + 1 - one):
            for three in range(DEGREE + 1 - one - two):
                degree = one + two + three
                if degree == 0:
                    continue
                height = x**one * y**two * z**three
                height = height / (degree * max(np.sqrt(np.mean(height**2)), 1e-9))
                found += [height[:, None] * axis for axis in np.eye(3)]
    return np.array(found)
