"""The step of the marks from the sizes of the rings in which they hold."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshmark.authentication.checks.setting_search import _densest, likeliest_setting
from meshmark.authentication.marks.plan import mark, plan
from meshmark.authentication.marks.ring_shapes import ring_shapes
from meshmark.authentication.marks.rings import ordered_rings
from meshmark.authentication.parameters import FAR_AWAY
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from tests.keys import ID, KEY
from tests.shapes import pebble


@given(
    st.floats(-40.0, -20.0),
    st.floats(0.0, 0.5),
    st.floats(0.05, 0.5),
    st.integers(20, 80),
    st.integers(0, 99),
)
def test_no_start_that_holds_all_is_left_out(
    start: float, first: float, width: float, count: int, seed: int
) -> None:
    """Rings of a regular surface are of few sizes: their marks leave the start of the interval open."""
    rng = np.random.default_rng(seed)
    values = np.sort(start + first + width * rng.random(count))
    begin, end, least, most = _densest(values)
    assert (begin, end) == (0, count)
    assert least <= start + 1e-9
    assert most >= start - 1e-9
    assert least == pytest.approx(values[-1] - 1.0, abs=0.3)


def test_marks_that_hold_by_luck_elsewhere_do_not_move_it() -> None:
    own = np.linspace(-30.9, -30.1, 60)
    values = np.sort(np.concatenate([own, [-34.2, -33.1, -28.0, -26.5]]))
    begin, end, least, most = _densest(values)
    assert values[begin] == own[0]
    assert end - begin == len(own)
    assert least <= -31.0 <= most


@pytest.mark.parametrize("times", [9.0, 9.6, 9.8, 10.0])
def test_a_step_at_the_edge_of_the_likely_ones_is_found_among_all(times: float) -> None:
    points, faces = pebble(72)
    surface = weld(Mesh(points, faces))
    error = times * FAR_AWAY * float(np.linalg.norm(np.ptp(points, axis=0)))
    planned = plan(surface, KEY, error)
    done = mark(planned, KEY, ID, lambda index: (index & np.uint32(15)).astype(np.uint16))
    rings = ordered_rings(faces, len(points))
    rounded = done.points + error * np.random.default_rng(1).uniform(-1.0, 1.0, points.shape)
    shapes = [ring_shapes(rounded, group) for group in rings]
    found = likeliest_setting(rounded, rings, shapes, KEY, None)
    assert found is not None
    assert abs(2.0 * np.log2(found.unit / done.step)) <= found.doubts


@pytest.mark.parametrize("nonce", [None, ID])
def test_the_shapes_of_the_sample_are_enough(nonce: int | None) -> None:
    """An unmarked surface, of which no more is read, does without those of all others."""
    points, faces = pebble(72)
    planned = plan(weld(Mesh(points, faces)), KEY, FAR_AWAY * float(np.linalg.norm(np.ptp(points, axis=0))))
    marked = mark(planned, KEY, ID, lambda index: (index & np.uint32(15)).astype(np.uint16)).points
    rings = ordered_rings(faces, len(points))
    shapes = [ring_shapes(marked, group) for group in rings]
    found = likeliest_setting(marked, rings, None, KEY, nonce)
    assert found == likeliest_setting(marked, rings, shapes, KEY, nonce)
    assert found is not None
    assert found.log10_chance < -10.0
