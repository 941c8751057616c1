"""Displacements that move offsets and the frame by chosen amounts, and are the least visible that do."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.keys import Key
from meshmark.geometry.areas import vertex_areas, vertex_normals
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.sampling import plan_samples
from meshmark.geometry.visibility import VisibleChange
from meshmark.ownership import bumps
from meshmark.ownership.bumps import FRAME_ROWS, Bumps, frame_gradient, frame_values
from meshmark.ownership.carriers.cells import measure_cells
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.nodes import find_nodes
from meshmark.ownership.carriers.selection import select_cells
from meshmark.ownership.parameters import EMBED_SELECTION, LONGEST_SAMPLE
from meshmark.ownership.visible_energy import visible_energy
from tests.shapes import pebble

LABEL = Label(bytes(16))
LATTICE = Lattice.keyed(Key(bytes(range(32))), 0.25, LABEL)


class Setting:
    """Bumps on a pebble: canonical points, faces, the cells that can be set, and how to read them again."""

    def __init__(self, across: int = 72) -> None:
        points, self.faces = pebble(across)
        self.points = canonical_frame(points, self.faces).to_canonical(points)
        self.placed = LATTICE.coordinates(self.points)
        self._sampler = plan_samples(self.placed, self.faces, LONGEST_SAMPLE)
        samples = self._sampler(self.placed)
        cells = measure_cells(samples)
        cells = cells.take(select_cells(cells, EMBED_SELECTION))
        self.seen = VisibleChange(self.points, self.faces)
        self.bumps = Bumps(self._sampler, samples, cells, LATTICE, self.seen)
        self.cells = cells.take(np.flatnonzero(self.bumps.free))

    def moved(self, length: np.ndarray) -> np.ndarray:
        """Return the points, lattice coordinates, after motions (p,) along the normals."""
        return self.placed + length[:, None] * self.bumps.normals

    def offsets(self, placed: np.ndarray) -> np.ndarray:
        """Return what the free cells' offsets are now."""
        now = measure_cells(self._sampler(placed))
        rows = find_nodes(now.nodes, self.cells.nodes)
        assert (rows >= 0).all()
        return now.offset[rows]

    def frame(self, placed: np.ndarray) -> np.ndarray:
        """Return the frame values (9,) of the points."""
        return frame_values(LATTICE.points(placed), self.faces)

    @property
    def energy(self):
        """The visible energy of motions along the normals."""
        areas = vertex_areas(self.placed, self.faces)
        gradient = frame_gradient(self.points, self.faces, self.bumps.normals @ LATTICE.axes)
        return visible_energy(self.placed, self.faces, areas, gradient, self.seen)


@pytest.fixture(scope="module")
def setting():
    """Their energy is added up a thousand points at a time, as that of large models is."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bumps, "ROWS", 1000)
        return Setting()


def test_frame_gradient_predicts_the_moments_of_a_displaced_surface():
    points, faces = pebble(16)
    points = canonical_frame(points, faces).to_canonical(points)
    normals = vertex_normals(points, faces)
    for waves in (1.0, 3.0):
        lengths = 1e-7 * np.sin(waves * points @ [1.0, 0.7, -0.4] + 0.3)
        moved = frame_values(points + lengths[:, None] * normals, faces)
        change = moved - frame_values(points, faces)
        predicted = frame_gradient(points, faces, normals) @ lengths
        assert np.abs(predicted - change).max() < 1e-4 * np.abs(change).max()


def test_most_cells_can_be_set(setting):
    assert setting.bumps.free.mean() > 0.8
    assert setting.bumps.cost.shape == (len(setting.cells.nodes),) * 2


def test_offsets_change_as_asked_and_the_frame_does_not(setting):
    asked = 1e-3 * np.random.default_rng(1).normal(size=len(setting.cells.nodes))
    after = setting.moved(setting.bumps.displacement(np.zeros(FRAME_ROWS), asked))
    left = setting.offsets(after) - setting.cells.offset - asked
    assert np.sqrt(np.mean(left**2)) < 0.1 * np.sqrt(np.mean(asked**2))
    assert np.abs(setting.frame(after) - setting.frame(setting.placed)).max() < 1e-5


def test_a_bend_changes_the_frame_as_asked(setting):
    asked = 1e-5 * np.random.default_rng(2).normal(size=FRAME_ROWS)
    after = setting.moved(setting.bumps.bend(asked))
    change = setting.frame(after) - setting.frame(setting.placed)
    np.testing.assert_allclose(change, asked, atol=0.05 * np.abs(asked).max())


def test_the_cost_is_the_visible_energy_of_the_displacement(setting):
    asked = 1e-3 * np.random.default_rng(3).normal(size=len(setting.cells.nodes))
    length = setting.bumps.displacement(np.zeros(FRAME_ROWS), asked)
    assert length @ setting.energy @ length == pytest.approx(asked @ setting.bumps.cost @ asked, rel=0.02)


def test_no_other_displacement_with_these_offsets_is_less_visible(setting):
    """Any other sum of the functions differs by one that changes nothing; energies add up, as at a minimum."""
    rng = np.random.default_rng(4)
    zero, asked = np.zeros(FRAME_ROWS), 1e-3 * rng.normal(size=len(setting.cells.nodes))
    length = setting.bumps.displacement(zero, asked)
    for _ in range(5):
        other = 1e-4 * setting.bumps.basis @ rng.normal(size=setting.bumps.basis.shape[1])
        change = setting.offsets(setting.moved(other)) - setting.cells.offset
        drift = setting.frame(setting.moved(other)) - setting.frame(setting.placed)
        idle = other - setting.bumps.displacement(drift, change)
        both = length + idle
        assert both @ setting.energy @ both > length @ setting.energy @ length
        across = abs(length @ setting.energy @ idle)
        assert across < 0.05 * np.sqrt((length @ setting.energy @ length) * (idle @ setting.energy @ idle))


def test_spread_is_what_noise_of_the_points_does_to_offsets(setting):
    rng = np.random.default_rng(5)
    noise = 1e-4
    changes = [
        setting.offsets(setting.moved(noise * rng.normal(size=len(setting.placed)))) - setting.cells.offset
        for _ in range(40)
    ]
    measured = np.std(changes, axis=0) / noise
    assert np.median(measured / setting.bumps.spread) == pytest.approx(1.0, abs=0.1)


def test_coefficients_are_those_of_the_displacement(setting):
    asked = np.random.default_rng(6).normal(size=len(setting.cells.nodes))
    zero = np.zeros(FRAME_ROWS)
    np.testing.assert_allclose(
        setting.bumps.basis @ setting.bumps.coefficients(zero, asked),
        setting.bumps.displacement(zero, asked),
    )
