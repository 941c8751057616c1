from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from meshmark.errors import CapacityError, InputError, MeshmarkError
from meshmark.recovery.mesh_coder import PLACE_BITS, decode_mesh, encode_mesh
from tests.counting import Share
from tests.recovery.surfaces import turned_first
from tests.shapes import pebble, sphere_with_a_spike

TETRAHEDRON = (
    8.0 * np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]),
    np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]),
)


def named_as_before(found: np.ndarray, known: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the faces `known` in the numbers of the places that theirs are nearest to, at most half a step off."""
    distance, number = cKDTree(places).query(found)
    assert distance.max() <= 0.87
    return number[known]


def test_coding_gives_the_faces_back_in_place():
    points, faces, _ = sphere_with_a_spike(16)
    places = 60.0 * points
    found, known = decode_mesh(encode_mesh(places, faces))
    assert turned_first(named_as_before(found, known, places)) == turned_first(faces)


def test_open_and_disagreeing_and_separate_faces_come_back():
    points, faces, _ = sphere_with_a_spike(16)
    rng = np.random.default_rng(1)
    faces = faces[rng.random(len(faces)) < 0.6]
    turned = rng.random(len(faces)) < 0.1
    faces = np.where(turned[:, None], faces[:, ::-1], faces)
    places = 60.0 * points
    found, known = decode_mesh(encode_mesh(places, faces))
    assert turned_first(named_as_before(found, known, places)) == turned_first(faces)


corners = st.lists(st.integers(0, 7), min_size=3, max_size=3, unique=True)


@settings(max_examples=200, deadline=None)
@given(
    st.lists(corners, min_size=1, max_size=20, unique_by=lambda face: tuple(np.roll(face, -np.argmin(face))))
)
def test_any_faces_come_back_whatever_edges_they_share(faces):
    places = 40.0 * np.concatenate([np.eye(3), -np.eye(3), [[1.0, 1.0, 1.0], [-1.0, -0.8, 0.5]]])
    found, known = decode_mesh(encode_mesh(places, np.array(faces)))
    assert turned_first(named_as_before(found, known, places)) == turned_first(np.array(faces))


def test_places_that_are_whole_numbers_of_steps_come_back_exactly_where_they_are_seeds():
    apart = np.array([[0, 1, 2], [3, 4, 5]])
    places = np.array([[0.0, 0, 0], [9, 0, 0], [0, 9, 0], [100, 100, 100], [-90, 7, 3], [0, -55, 1]])
    found, known = decode_mesh(encode_mesh(places, apart))
    assert np.array_equal(found, places)
    assert np.array_equal(known, apart)


def test_bytes_are_few_where_faces_are_regular():
    """A closed surface of p points and 2 p faces as plain numbers takes 3 bits p + 6 p log2(p) bits: far more."""
    points, faces = pebble(40)
    content = encode_mesh(60.0 * points, faces)
    assert 8 * len(content) / len(points) < 20


def test_the_bytes_are_the_same_every_time():
    points, faces = pebble(16)
    assert encode_mesh(60.0 * points, faces) == encode_mesh(60.0 * points, faces)


def test_places_beyond_the_reach_of_the_coder_are_refused():
    points, faces = TETRAHEDRON
    largest = (2.0**PLACE_BITS - 1.0) / 8.0
    found, _ = decode_mesh(encode_mesh(largest * points, faces))
    assert np.abs(found).max() == pytest.approx(2.0**PLACE_BITS - 1.0, abs=0.5)
    with pytest.raises(CapacityError, match="too far from each other"):
        encode_mesh(1.01 * largest * points, faces)


def test_changed_bytes_are_refused_or_read_as_a_mesh():
    whole, rng = encode_mesh(*TETRAHEDRON), np.random.default_rng(0)
    with Share(0.05) as share:
        for _ in range(400):
            content = bytearray(whole)
            content[rng.integers(len(content))] = rng.integers(256)
            share.case()
            try:
                places, faces = decode_mesh(bytes(content))
            except MeshmarkError:
                continue
            share.asserted()
            assert np.isfinite(places).all()
            assert faces.shape == (len(faces), 3)
            assert faces.min(initial=0) >= 0
            assert faces.max(initial=-1) < len(places)


def test_bytes_that_end_too_early_are_refused():
    content = encode_mesh(60.0 * pebble(24)[0], pebble(24)[1])
    with pytest.raises(InputError, match="ends too early"):
        decode_mesh(content[: len(content) // 2])
