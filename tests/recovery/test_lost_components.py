from __future__ import annotations

import numpy as np
import pytest

from meshmark.recovery.borders import border_edges
from meshmark.recovery.lost_components import with_lost_components
from tests.recovery.surfaces import euler, off
from tests.shapes import pebble

USUAL = 0.01


def together(*parts: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return several surfaces as one."""
    starts = np.cumsum([0, *(len(points) for points, _ in parts)])
    return (
        np.concatenate([points for points, _ in parts]),
        np.concatenate([faces + start for (_, faces), start in zip(parts, starts[:-1], strict=True)]),
    )


@pytest.fixture(scope="module")
def body() -> tuple[np.ndarray, np.ndarray]:
    return pebble(24)


def moon(away: float, across: int = 16) -> tuple[np.ndarray, np.ndarray]:
    points, faces = pebble(across)
    return 0.3 * points + [away, 0.0, 0.0], faces


def test_a_component_that_is_gone_comes_back_behind_what_is_there(body):
    lost = moon(5.0)
    points, faces = with_lost_components(*body, together(lost, body), USUAL)
    assert np.array_equal(points[: len(body[0])], body[0])
    assert np.array_equal(faces[: len(body[1])], body[1])
    new = faces[len(body[1]) :]
    assert new.min() == len(body[0])
    assert new.max() == len(points) - 1
    assert not len(border_edges(new))
    assert euler(new) == 2
    assert off(*lost, points[len(body[0]) :]).max() < 1e-12
    assert off(points, new, lost[0]).max() == 0.0


def test_its_faces_become_as_small_as_those_of_the_rest(body):
    coarse = 6.0 * moon(2.0)[0], moon(2.0)[1]
    points, faces = with_lost_components(*body, together(body, coarse), USUAL)
    own = np.sqrt(np.square(body[0][body[1]] - body[0][np.roll(body[1], 1, axis=1)]).sum(axis=2).mean())
    new = faces[len(body[1]) :]
    assert len(new) > 2 * len(coarse[1])
    assert np.linalg.norm(points[new] - points[np.roll(new, 1, axis=1)], axis=2).max() < 1.8 * own


def test_several_components_come_back_at_once(body):
    _, faces = with_lost_components(*body, together(moon(5.0), body, moon(-4.0), moon(9.0)), USUAL)
    assert euler(faces[len(body[1]) :]) == 6


def test_nothing_is_added_where_nothing_is_lost(body):
    shifted = body[0] + [0.0, 0.0, USUAL], body[1]
    points, faces = with_lost_components(*body, shifted, USUAL)
    assert points is body[0]
    assert faces is body[1]


def test_a_component_that_is_partly_there_is_not_lost(body):
    half = together(body, moon(5.0))
    kept = half[1][~((half[1] >= len(body[0])).all(axis=1) & (half[0][half[1]][:, :, 2] > 0.0).any(axis=1))]
    assert len(body[1]) < len(kept) < len(half[1])
    _, faces = with_lost_components(half[0], kept, half, USUAL)
    assert np.array_equal(faces, kept)


def test_a_component_of_fewer_than_four_points_is_none(body):
    triangle = np.array([[9.0, 0, 0], [9, 1, 0], [9, 0, 1]]), np.array([[0, 1, 2]])
    _, faces = with_lost_components(*body, together(body, triangle), USUAL)
    assert np.array_equal(faces, body[1])
