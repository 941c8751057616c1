from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.areas import area_vectors, face_areas, vertex_normals
from meshmark.geometry.sampling import Samples, gathered, plan_samples
from tests.shapes import pebble


@pytest.mark.parametrize("longest", [10.0, 0.2, 0.05])
def test_samples_add_up_to_the_surface(longest):
    points, faces = pebble(16)
    samples = plan_samples(points, faces, longest)(points)
    assert samples.areas.sum() == pytest.approx(face_areas(points, faces).sum())
    np.testing.assert_allclose(
        samples.vectors.sum(axis=0), area_vectors(points, faces).sum(axis=0), atol=1e-12
    )
    middle = points[faces].mean(axis=1)
    np.testing.assert_allclose(
        samples.areas @ samples.positions, face_areas(points, faces) @ middle, atol=1e-12
    )


def test_finer_samples_converge_to_the_integral_of_a_smooth_function():
    points, faces = pebble(16)

    def integral(longest: float) -> float:
        samples = plan_samples(points, faces, longest)(points)
        return float(samples.areas @ np.exp(-(samples.positions**2).sum(axis=1)))

    exact = integral(0.01)
    errors = [abs(integral(longest) - exact) for longest in (0.2, 0.1, 0.05)]
    assert errors[0] > 3 * errors[1] > 9 * errors[2]  # second order


def test_a_sliver_takes_samples_along_it_only():
    points = np.array([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [4.0, 0.05, 0.0]])
    for turn in range(3):
        samples = plan_samples(points, np.roll([[0, 1, 2]], turn, axis=1), 0.1)(points)
        split = samples.positions[3:]
        assert len(split) < 150  # sqrt(2) to the longest piece
        assert np.diff(np.sort(split[:, 0])).max() < 0.2
        np.testing.assert_allclose(samples.areas @ samples.positions, 0.25 * points.mean(axis=0))


def test_pieces_know_the_second_moment_of_a_triangle():
    """Of area A, with corners a, b, c and centroid m: A / 12 (a a' + b b' + c c' + 9 m m')."""
    points = np.random.default_rng(3).normal(size=(3, 3))
    samples = plan_samples(points, np.array([[2, 0, 1]]), 0.02)(points)
    second = (samples.positions.T * samples.areas) @ samples.positions
    exact = face_areas(points, np.array([[0, 1, 2]]))[0] / 12.0 * (points.T @ points)
    exact += face_areas(points, np.array([[0, 1, 2]]))[0] * 0.75 * np.outer(points.mean(0), points.mean(0))
    np.testing.assert_allclose(second, exact, rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize("longest", [10.0, 0.1])
def test_normal_motion_is_the_flux_of_the_displacement(longest):
    points, faces = pebble(16)
    sampler, normals = plan_samples(points, faces, longest), vertex_normals(points, faces)
    samples = sampler(points)
    lengths = np.cos(points[:, 0])
    moved = sampler(points + 1e-7 * lengths[:, None] * normals)
    flux = np.einsum("ij,ij->i", (moved.positions - samples.positions) / 1e-7, samples.vectors)
    np.testing.assert_allclose(sampler.normal_motion(samples, normals) @ lengths, flux, atol=1e-7)


def test_gathered_samples_say_the_same_of_smooth_windows():
    points, faces = pebble(144)
    samples = plan_samples(points, faces, 0.05)(points)
    fewer = gathered(samples, 0.05)
    assert 50 < len(fewer.areas) < 0.6 * len(samples.areas)
    np.testing.assert_allclose(fewer.areas.sum(), samples.areas.sum())
    np.testing.assert_allclose(fewer.vectors.sum(axis=0), samples.vectors.sum(axis=0), atol=1e-12)

    def flux(of):
        window = np.exp(-0.5 * np.sum((of.positions - points[0]) ** 2, axis=1) / 0.2**2)
        return window @ of.vectors

    np.testing.assert_allclose(
        flux(fewer), flux(samples), rtol=0.02, atol=0.002 * np.abs(flux(samples)).max()
    )


def test_gathering_keeps_the_sheets_of_a_thin_wall_apart():
    """Two sheets that face away from each other: their moment x . a is the volume between them, not zero."""
    x, y = np.meshgrid(np.linspace(0, 1, 30), np.linspace(0, 1, 30))
    top = np.column_stack([x.ravel(), y.ravel(), np.full(900, 0.01)])
    both = np.concatenate([top, top * [1, 1, -1]])
    vectors = np.concatenate([np.tile([0, 0, 1 / 900], (900, 1)), np.tile([0, 0, -1 / 900], (900, 1))])
    fewer = gathered(Samples(positions=both, vectors=vectors, areas=np.full(1800, 1 / 900)), 0.1)
    assert len(fewer.areas) < 600
    np.testing.assert_allclose(np.einsum("ij,ij->", fewer.positions, fewer.vectors), 0.02)


def test_nothing_gathers_to_nothing():
    empty = Samples(positions=np.zeros((0, 3)), vectors=np.zeros((0, 3)), areas=np.zeros(0))
    assert len(gathered(empty, 0.1).areas) == 0
