"""A surface is shaped so that its cells say the bits, is hardly seen to be, and predicts what noise leaves."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.geometry.sampling import plan_samples
from meshmark.geometry.surface_of import surface_of
from meshmark.geometry.visibility import VisibleChange
from meshmark.mesh import Mesh
from meshmark.ownership.carriers.cells import measure_cells
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.quantisation import bit_phase
from meshmark.ownership.carriers.selection import select_cells
from meshmark.ownership.parameters import EXTRACT_SELECTION, LONGEST_SAMPLE, NEEDED_BITS
from meshmark.ownership.shaping import Shaping
from tests.shapes import pebble

LABEL = Label(bytes(16))
KEY = Key(bytes(range(32)))
LATTICE = Lattice.keyed(KEY, 0.21, LABEL)
BITS = Codec(KEY).encode(0x0123456789ABCDEF)
SURFACE = surface_of(Mesh(*pebble(96)))
SEEN = VisibleChange(SURFACE.points, SURFACE.faces)
STEP = 0.03


def shaping(share: float = 0.025) -> Shaping:
    return Shaping(SURFACE, LATTICE, BITS, SEEN, share)


@pytest.fixture(scope="module")
def standard():
    return shaping()


def cosines(points: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the cosines (n,) of the phases against the written bits, in the old frame, and who is a pilot."""
    placed = LATTICE.coordinates(SURFACE.frame.to_canonical(points))
    cells = measure_cells(plan_samples(placed, SURFACE.faces, LONGEST_SAMPLE)(placed))
    cells = cells.take(select_cells(cells, EXTRACT_SELECTION))
    keys = LATTICE.keys(cells.nodes)
    signs = np.where(keys.pilot, 1.0, 1.0 - 2.0 * BITS[keys.code_index])
    return signs * np.cos(bit_phase(cells.offset, keys.dither, step)), keys.pilot


def test_the_shaped_surface_says_the_bits_and_the_pilots_as_foretold(standard):
    agreement, pilot = cosines(standard.shaped(STEP), STEP)
    before = cosines(SURFACE.points, STEP)[0]
    assert abs(before.mean()) < 0.2
    told = standard.expected_cosine(STEP, 0.0)
    assert told > 0.5
    for kind in (pilot, ~pilot):
        assert agreement[kind].mean() == pytest.approx(told, abs=0.12)


def test_steps_are_judged_by_one_word_whichever_is_shaped(standard):
    other = Codec(KEY).encode(7)
    alike = Shaping(SURFACE, LATTICE, other, SEEN, 0.025, typical=BITS)
    unlike = Shaping(SURFACE, LATTICE, other, SEEN, 0.025)
    values = [
        (each.rms(STEP), each.borne(STEP), each.loudness(STEP), each.expected_cosine(STEP, 0.0))
        for each in (standard, alike, unlike)
    ]
    assert values[0] == values[1] != values[2]
    assert np.array_equal(alike.shaped(STEP), unlike.shaped(STEP))
    assert cosines(alike.shaped(STEP), STEP)[0].mean() < 0.5 < cosines(standard.shaped(STEP), STEP)[0].mean()


def test_what_may_be_seen_sets_how_far_cells_go():
    told, shares = [], []
    for share in (0.003, 0.025, 0.2):
        made = shaping(share)
        told.append(made.expected_cosine(STEP, 0.0))
        shares.append(SEEN.of(made.shaped(STEP)).share)
        assert shares[-1] < 2.0 * share + 0.01
    assert told == sorted(told)
    assert shares == sorted(shares)
    assert shares[-1] > 0.03


def test_more_noise_tells_less_and_larger_steps_are_louder(standard):
    diagonal = float(np.linalg.norm(np.ptp(SURFACE.points, axis=0)))
    told = [standard.expected_cosine(STEP, noise * diagonal) for noise in (0.0, 1e-3, 3e-3, 1e-2)]
    assert told == sorted(told, reverse=True)
    assert told[-1] < 0.3 * told[0]
    assert standard.loudness(2.0 * STEP) > 1.4 * standard.loudness(STEP)


def test_the_first_order_predicts_how_far_points_move(standard):
    moved = np.linalg.norm(standard.shaped(STEP) - SURFACE.points, axis=1)
    assert np.sqrt(np.mean(moved**2)) == pytest.approx(standard.rms(STEP), rel=0.15)


def test_the_noise_borne_is_that_under_which_the_bits_needed_are_left(standard):
    borne = standard.borne(STEP)
    left = standard.expected_cosine(STEP, borne)
    assert standard.carriers * left**2 / np.log(2.0) == pytest.approx(NEEDED_BITS, rel=0.02)
    assert shaping(1e-6).borne(1.0) == 0.0


def test_the_prediction_of_noise_is_what_noise_does(standard):
    """The cosines of the shaped surface under noise along its normals, against those without."""
    points = standard.shaped(STEP)
    rng = np.random.default_rng(3)
    noise = 7e-4 * float(np.linalg.norm(np.ptp(SURFACE.points, axis=0)))
    clean = cosines(points, STEP)[0].mean()
    noised = np.mean(
        [cosines(points + noise * rng.normal(size=points.shape), STEP)[0].mean() for _ in range(5)]
    )
    foretold = standard.expected_cosine(STEP, noise) / standard.expected_cosine(STEP, 0.0)
    assert noised / clean == pytest.approx(foretold, abs=0.08)
