"""Models that were marked with the attacked key, as an attacker holds them, and what he learns from one of them.

He is granted the exact pose of the lattices of the models that he holds: it can nearly be had of an original and
its marked copy (`pose.py`), and nothing better.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from claims.security.options import KEY, Options
from meshmark.coding.keyed_code import LENGTH
from meshmark.coding.known_words import KnownWords
from meshmark.errors import MeshmarkError
from meshmark.geometry.sampling import plan_samples
from meshmark.geometry.surface_of import surface_of
from meshmark.geometry.visibility import VisibleChange
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.ownership.carriers.lattice import CellKeys, Lattice
from meshmark.ownership.carriers.pose import Pose
from meshmark.ownership.embedding import embed
from meshmark.ownership.ownership_mark import OwnershipMark
from meshmark.ownership.parameters import LONGEST_SAMPLE
from meshmark.ownership.search.measurement import Measurement, read_cells
from meshmark.ownership.shaping import Shaping
from meshmark.ownership.vertex_displacement import displacement_rms
from meshmark.strengths import VISIBLE_SHARES

__all__ = ["Donor", "Learnt", "donors", "forged", "learnt", "measured"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Donor:
    """A model, and its copy that carries an id in cells; rms: displacement of the copy over the diagonal."""

    name: str
    original: Mesh
    marked: Mesh
    mark: OwnershipMark
    id: int
    rms: float

    @classmethod
    def of(cls, name: str, original: Mesh, id: int, *, strength: str = "standard") -> Donor:
        """Mark a model with the id alone; raises `CapacityError` where it cannot carry it."""
        made = embed(original, KEY, id=id, strength=strength)
        rms = displacement_rms(original, made.mesh) / surface_of(original).diagonal
        return cls(name=name, original=original, marked=made.mesh, mark=made.mark, id=id, rms=rms)

    @property
    def lattice(self) -> Lattice:
        """The lattice of the mark, which only the key tells."""
        return Lattice.keyed(KEY, self.mark.spacing, self.mark.label)


def donors(options: Options, *folders: str, id: int | None = None) -> Iterator[Donor]:
    """Yield the models that take a mark in cells, under one id or ids of their own."""
    for number, (name, mesh) in enumerate(options.meshes(*folders)):
        try:
            made = Donor.of(name, mesh, number + 1 if id is None else id)
        except MeshmarkError:
            continue
        print(
            f"{name}: {len(mesh.vertices)} vertices, {'points' if made.mark.at_points else 'cells'}",
            flush=True,
        )
        if not made.mark.at_points:
            yield made


def measured(mesh: Mesh, lattice: Lattice) -> Measurement:
    """Return the cells of a mesh as it stands, in its own canonical frame."""
    surface = surface_of(mesh)
    canonical = surface.frame.to_canonical(surface.points)
    samples = plan_samples(canonical, surface.faces, LONGEST_SAMPLE * lattice.spacing)(canonical)
    return Measurement.of(lattice, read_cells(samples, lattice, Pose.turned(np.eye(3))))


@dataclass(frozen=True, eq=False, kw_only=True)
class Learnt(Lattice):
    """A lattice of which phases are known instead of the key: turns[node] of a step, dither and bit together."""

    turns: dict[tuple[int, ...], float] = field(default_factory=dict)

    def keys(self, nodes: IntArray) -> CellKeys:
        """Return that each cell wants the phase that was seen there, others any."""
        dither = np.array([self.turns.get(tuple(node), 0.5) for node in nodes.tolist()])
        return CellKeys(
            code_index=np.zeros(len(nodes), np.int64),
            dither=dither.reshape(len(nodes)),
            pilot=np.ones(len(nodes), bool),
        )

    def knows(self, nodes: IntArray) -> int:
        """Return of how many of these nodes (n, 3) the phase is known."""
        return sum(tuple(node) in self.turns for node in nodes.tolist())


def learnt(donor: Donor, turns: FloatArray | None = None) -> Learnt:
    """Return what a donor shows of its lattice; turns: (n,) of its cells to be taken instead of those seen."""
    lattice = donor.lattice
    cells = measured(donor.marked, lattice).cells
    seen = cells.offset / donor.mark.step if turns is None else turns
    return Learnt(
        spacing=lattice.spacing,
        label=lattice.label,
        axes=lattice.axes,
        shift=lattice.shift,
        _words=KnownWords(b"", 3),
        turns=dict(zip(map(tuple, cells.nodes.tolist()), np.mod(seen, 1.0).tolist(), strict=True)),
    )


def forged(target: Mesh, lattice: Learnt, step: float) -> Mesh:
    """Return a model whose cells have the phases that were learnt, as an embedding puts bits into them."""
    surface = surface_of(target)
    seen = VisibleChange(surface.points, surface.faces)
    shaping = Shaping(surface, lattice, np.zeros(LENGTH, np.uint8), seen, VISIBLE_SHARES["strong"])
    points = shaping.shaped(step)
    return target.with_vertices(points[surface.point_of_vertex])
