from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from meshmark.errors import CapacityError, InputError, MeshmarkError
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.geometry.frame import canonical_frame
from meshmark.recovery.borders import border_edges, loops, strip
from meshmark.recovery.mesh_coder import decode_mesh, encode_mesh
from meshmark.recovery.miniature import miniature, read_miniature
from meshmark.recovery.range_coder import Decoder, Encoder, Model
from meshmark.recovery.refining import split_long_edges
from meshmark.recovery.simplify import simplify
from tests.counting import Share
from tests.shapes import pebble, sphere_with_a_spike


def distances(places: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Distance of each canonical point of the pebble from a miniature of it."""
    points, own = pebble(48)
    return SurfaceIndex(places, faces).nearest(canonical_frame(points, own).to_canonical(points)).distances


def turned_first(faces: np.ndarray) -> list[tuple[int, ...]]:
    """Return the faces, each from its smallest corner on, sorted."""
    return sorted(tuple(np.roll(face, -int(np.argmin(face))).tolist()) for face in faces)


def named_as_before(found: np.ndarray, known: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the faces `known` in the numbers of the places that theirs are nearest to, at most half a step off."""
    distance, number = cKDTree(places).query(found)
    assert distance.max() <= 0.87
    return number[known]


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


def test_a_miniature_needs_some_bytes():
    with pytest.raises(CapacityError, match="does not fit 10 bytes"):
        miniature(*pebble(24), 10)


@pytest.mark.parametrize(
    "content", [b"", b"\x00abc", b"\x07", b"\x07" + bytes(50), bytes([7]) + b"\xff" * 400]
)
def test_other_bytes_are_no_miniature(content):
    with pytest.raises(InputError):
        read_miniature(content)


def test_changed_bytes_never_break_the_reader():
    whole = miniature(*pebble(24), 80)

    @settings(max_examples=200, deadline=None)
    @given(
        st.lists(st.tuples(st.integers(1, len(whole) - 1), st.integers(0, 255)), min_size=1, max_size=3),
        st.binary(max_size=3),
    )
    def changed(edits, behind):
        content = bytearray(whole + behind)
        for place, value in edits:
            content[place] = value
        share.case()
        try:
            places, faces = read_miniature(bytes(content))
        except MeshmarkError:
            return
        share.asserted()
        assert np.isfinite(places).all()
        assert 0 <= faces.min() <= faces.max() < len(places)

    with Share(0.1) as share:
        changed()


def test_coding_gives_the_faces_back_in_place():
    points, faces, _ = sphere_with_a_spike(16)
    places = 60.0 * points
    found, known = decode_mesh(encode_mesh(places, faces, 8), 8)
    assert turned_first(named_as_before(found, known, places)) == turned_first(faces)


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


def test_open_and_disagreeing_and_separate_faces_come_back():
    points, faces, _ = sphere_with_a_spike(16)
    rng = np.random.default_rng(1)
    faces = faces[rng.random(len(faces)) < 0.6]
    turned = rng.random(len(faces)) < 0.1
    faces = np.where(turned[:, None], faces[:, ::-1], faces)
    places = 60.0 * points
    found, known = decode_mesh(encode_mesh(places, faces, 8), 8)
    assert turned_first(named_as_before(found, known, places)) == turned_first(faces)


@given(st.lists(st.integers(0, 4), max_size=300))
def test_the_range_coder_gives_symbols_and_bits_back(symbols):
    out, model = Encoder(), Model([1, 5, 1, 1, 30])
    for symbol in symbols:
        out.symbol(model, symbol)
        out.bits(symbol * 1000, 13)
    read, model = Decoder(out.finish()), Model([1, 5, 1, 1, 30])
    assert [(read.symbol(model), read.bits(13)) for _ in symbols] == [(s, s * 1000) for s in symbols]


def test_the_range_coder_is_near_the_entropy():
    rng = np.random.default_rng(2)
    symbols = rng.choice(4, size=4000, p=[0.9, 0.06, 0.03, 0.01])
    out, model = Encoder(), Model([1, 1, 1, 1])
    for symbol in symbols:
        out.symbol(model, int(symbol))
    share = np.bincount(symbols, minlength=4) / len(symbols)
    assert 8 * len(out.finish()) < 1.04 * len(symbols) * -(share @ np.log2(share))


@pytest.mark.parametrize("count", [20, 60, 200])
def test_simplification_stays_closed_and_near(count):
    points, faces = pebble(48)
    few, small = simplify(points, faces, count)
    assert len(few) == count
    assert not len(border_edges(small))
    assert len(few) - 3 * len(small) // 2 + len(small) == 2  # still a sphere
    off = SurfaceIndex(few, small).nearest(points).distances
    assert np.sqrt((off**2).mean()) < 1.6 / count


def test_simplification_keeps_borders_in_place():
    points, faces, _ = sphere_with_a_spike(24)
    part = faces[(points[faces][:, :, 2] > 0.1).all(axis=1)]
    few, small = simplify(points, part, 40)
    rim = few[np.unique(border_edges(small))]
    low = points[part][:, :, 2].min()
    assert len(rim) >= 6
    assert np.abs(rim[:, 2] - low).max() < 0.05


def test_long_edges_are_split_and_the_surface_stays():
    points, faces, _ = sphere_with_a_spike(16)
    fine, small = split_long_edges(points, faces, 0.15)
    ends = fine[small] - fine[small[:, [1, 2, 0]]]
    assert np.sqrt((ends**2).sum(axis=2)).max() <= 0.15
    assert not len(border_edges(small))
    assert SurfaceIndex(points, faces).nearest(fine).distances.max() < 1e-12

    def area(places: np.ndarray, corners: np.ndarray) -> np.ndarray:
        a, b, c = places[corners].transpose(1, 0, 2)
        return np.cross(b - a, c - a).sum(axis=0), np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()

    assert area(fine, small)[1] == pytest.approx(area(points, faces)[1])


def test_border_loops_are_simple_and_all_edges_are_in_one():
    points, faces, _ = sphere_with_a_spike(24)
    keep = (np.abs(points[faces][:, :, 2]) < 0.5).all(axis=1)
    edges = border_edges(faces[keep])
    found = loops(edges)
    assert len(found) == 2
    walked = {(int(a), int(b)) for loop in found for a, b in zip(loop, np.roll(loop, -1), strict=True)}
    assert walked == {tuple(edge) for edge in edges.tolist()}


@pytest.mark.parametrize("counts", [(10, 10), (30, 7), (5, 40)])
def test_a_strip_closes_the_gap_between_two_rings(counts):
    def ring(count: int, radius: float) -> np.ndarray:
        turn = 2 * np.pi * np.arange(count) / count
        return radius * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)

    one, other = ring(counts[0], 2.0), ring(counts[1], 1.0)
    faces = strip(one, other, closed=True)
    assert len(faces) == sum(counts)
    inner = {frozenset(edge) for edge in border_edges(faces).tolist()}
    rings = [np.arange(counts[0]), counts[0] + np.arange(counts[1])]
    assert inner == {
        frozenset((int(a), int(b))) for ring in rings for a, b in zip(ring, np.roll(ring, -1), strict=True)
    }
    places = np.concatenate([one, other])
    a, b, c = places[faces].transpose(1, 0, 2)
    heights = np.cross(b - a, c - a)[:, 2]
    assert (heights > -1e-12).all()
