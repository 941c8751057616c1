from __future__ import annotations

from unittest.mock import patch

import numpy as np
import pytest

from meshmark.errors import CapacityError, InputError
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.geometry.frame import canonical_frame
from meshmark.recovery import miniature as miniature_module
from meshmark.recovery import simplify as simplify_module
from meshmark.recovery.borders import border_edges
from meshmark.recovery.miniature import SMALLEST, miniature, read_miniature
from meshmark.recovery.simplify import simplify
from tests.shapes import hoop, pebble


def distances(places: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Distance of each canonical point of the pebble from a miniature of it."""
    points, own = pebble(48)
    return SurfaceIndex(places, faces).nearest(canonical_frame(points, own).to_canonical(points)).distances


@pytest.mark.parametrize("size", [60, 150, 400, 1500])
def test_a_miniature_fits_its_bytes_and_is_closed(size):
    content = miniature(*pebble(48), size)
    places, faces = read_miniature(content)
    assert 0.8 * size < len(content) <= size
    assert not len(border_edges(faces))
    assert len(places) > size / 5


def test_more_bytes_buy_a_closer_miniature():
    points, faces = pebble(48)
    errors = [
        float(np.sqrt((distances(*read_miniature(miniature(points, faces, size))) ** 2).mean()))
        for size in (80, 300, 1200)
    ]
    assert errors[0] > 2 * errors[1] > 4 * errors[2]
    assert errors[1] < 0.012


def test_a_miniature_lies_in_canonical_coordinates():
    points, faces = pebble(48)
    one = miniature(points, faces, 300)
    assert one == miniature(points, faces, 300)
    there = read_miniature(miniature(7.0 * points[:, [1, 2, 0]] + 3.0, faces, 300))
    assert np.sqrt((distances(*there) ** 2).mean()) < 0.02


@pytest.mark.parametrize("size", [100, 700, 2000])
def test_a_miniature_is_simplified_by_the_library_once_and_coded_about_once(size):
    """Of the walks over a mesh one estimates the size; a second whole one corrects the first, a third is rare."""
    points, faces = pebble(100)
    with (
        patch.object(simplify_module, "coarse_surface", wraps=simplify_module.coarse_surface) as library,
        patch.object(miniature_module, "estimated_size", wraps=miniature_module.estimated_size) as estimates,
        patch.object(miniature_module, "encode_mesh", wraps=miniature_module.encode_mesh) as whole,
    ):
        miniature(points, faces, size)
    assert library.call_count == 1
    assert estimates.call_count == 1
    assert 1 <= whole.call_count <= 3


def test_a_miniature_of_an_earlier_version_is_refused_by_its_first_byte():
    content = miniature(*pebble(48), 300)
    for bits in range(4, 14):
        with pytest.raises(InputError, match="this version"):
            read_miniature(bytes([bits]) + content[1:])


def test_a_part_that_cannot_get_simpler_is_coded_more_coarsely():
    """A hoop keeps its hole, and seven points at least: in few bytes their places are less exact."""
    points, faces = hoop(long=60, around=8, thin=0.3)
    finer, coarser = (miniature(points, faces, size) for size in (400, SMALLEST))
    assert coarser[0] < finer[0]
    assert len(read_miniature(coarser)[0]) < len(read_miniature(finer)[0])


def test_a_miniature_needs_some_bytes():
    with pytest.raises(CapacityError, match="does not fit the 10 bytes"):
        miniature(*pebble(24), 10)


@pytest.mark.parametrize(
    "content", [b"", b"\x00abc", b"\x07", b"\x07" + bytes(50), bytes([7]) + b"\xff" * 400]
)
def test_other_bytes_are_no_miniature(content):
    with pytest.raises(InputError):
        read_miniature(content)


@pytest.mark.parametrize("away", [3.0, 40.0, 2000.0])
def test_parts_far_from_the_rest_come_back_in_place(away):
    points, faces = pebble(40)
    small, others = pebble(20)
    both = (
        np.concatenate([points, 0.3 * small + [away, 0.0, 0.0]]),
        np.concatenate([faces, others + len(points)]),
    )
    canonical = canonical_frame(*both).to_canonical(both[0])
    places, corners = read_miniature(miniature(*both, 500))
    off = SurfaceIndex(places, corners).nearest(canonical).distances
    assert off.max() < 0.2
    assert np.ptp(places, axis=0) == pytest.approx(np.ptp(canonical, axis=0), abs=0.3)


def leaf_cards(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return cards of four points and two faces each: more points than the library is asked to leave faces."""
    random = np.random.default_rng(count)
    middle, axes = random.normal(size=(count, 1, 3)), random.normal(size=(count, 2, 3))
    corner = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    points = (middle + 0.05 * corner @ axes).reshape(-1, 3)
    return points, (4 * np.arange(count)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)


@pytest.mark.parametrize("cards", [700, 1000, 2500])
def test_a_soup_with_fewer_faces_than_the_target_is_simplified(cards):
    points, faces = leaf_cards(cards)
    few, small = simplify(points, faces, 300)
    assert 0 < len(small) <= len(faces)
    assert len(few) <= len(points)


def test_a_soup_gets_a_miniature():
    assert len(miniature(*leaf_cards(700), 500)) <= 500
