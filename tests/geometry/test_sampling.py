from __future__ import annotations

import numpy as np
import pytest

from meshmark.geometry.areas import area_vectors, face_areas, vertex_normals
from meshmark.geometry.sampling import plan_samples
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


@pytest.mark.parametrize("longest", [10.0, 0.1])
def test_normal_motion_is_the_flux_of_the_displacement(longest):
    points, faces = pebble(16)
    sampler, normals = plan_samples(points, faces, longest), vertex_normals(points, faces)
    samples = sampler(points)
    lengths = np.cos(points[:, 0])
    moved = sampler(points + 1e-7 * lengths[:, None] * normals)
    flux = np.einsum("ij,ij->i", (moved.positions - samples.positions) / 1e-7, samples.vectors)
    np.testing.assert_allclose(sampler.normal_motion(samples, normals) @ lengths, flux, atol=1e-7)
