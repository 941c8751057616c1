from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array, eye_array
from scipy.sparse.linalg import expm_multiply
from scipy.special import ive

from meshmark.geometry import scale_space
from meshmark.geometry.adjacency import mean_squared_edge, unique_edges
from meshmark.geometry.scale_space import discrete_gaussian, discrete_gaussian_sum, random_walk
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray
from tests.counting import some
from tests.packed import read_packed

ALPHAS = np.array([0.0, 1e-6, 0.3, 1.0, 7.5, 40.0, 300.0])
REAL = ["models/train/casting_5096.off.xz", "models/train/open_spot_low_resolution.off.xz"]


def path_walk(length: int) -> csr_array:
    at = np.arange(length - 1)
    return random_walk(np.zeros((length, 3)), np.stack([at, at + 1], axis=1))


def test_a_path_carries_the_bessel_kernel_of_the_paper() -> None:
    length, middle = 601, 300  # the ends are too far away to matter: ive(300, 300) is about 1e-60
    impulse = np.zeros((length, 1))
    impulse[middle] = 1.0
    smoothed = discrete_gaussian(path_walk(length), impulse, ALPHAS)[:, :, 0]
    expected = ive(np.abs(np.arange(length) - middle), ALPHAS[:, None])
    np.testing.assert_allclose(smoothed[:6], expected[:6], rtol=0, atol=1e-12)
    np.testing.assert_allclose(smoothed[6, 150:450], expected[6, 150:450], rtol=0, atol=1e-12)


def test_a_cycle_carries_the_periodic_bessel_kernel() -> None:
    length = 12
    at = np.arange(length)
    edges = np.array(sorted(sorted((int(i), int(i + 1) % length)) for i in at))
    walk = random_walk(np.zeros((length, 3)), edges)
    smoothed = discrete_gaussian(walk, np.eye(length)[:, :1], ALPHAS)[:, :, 0]
    images = np.abs(at[:, None] + length * np.arange(-40, 41))
    expected = ive(images, ALPHAS[:, None, None]).sum(axis=2)
    np.testing.assert_allclose(smoothed, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("weights", ["uniform", "inverse_length"])
def test_a_random_mesh_equals_the_dense_exponential(weights: str) -> None:
    points, faces = random_mesh(60)
    walk = random_walk(points, unique_edges(faces), weights)  # type: ignore[arg-type]
    rates, vectors = np.linalg.eig(walk.toarray())
    smoothed = discrete_gaussian(walk, points, ALPHAS)
    for alpha, found in some(zip(ALPHAS, smoothed, strict=True)):
        expected = (vectors * np.exp(-alpha * (1 - rates))) @ np.linalg.solve(vectors, points)
        np.testing.assert_allclose(found, expected, atol=1e-10)
    total = discrete_gaussian_sum(walk, points, ALPHAS)
    np.testing.assert_allclose(total, smoothed.sum(axis=0), atol=1e-11)


def test_constants_and_lone_points_stay() -> None:
    points, faces = random_mesh(30)
    points = np.concatenate([points, [[9.0, 8.0, 7.0]]])
    walk = random_walk(points, unique_edges(faces))
    np.testing.assert_allclose(walk.sum(axis=1), 1.0)
    np.testing.assert_allclose(discrete_gaussian(walk, np.ones((31, 2)), ALPHAS), 1.0, atol=1e-11)
    lone = discrete_gaussian(walk, points, ALPHAS)[:, -1]
    np.testing.assert_allclose(lone, np.tile(points[-1], (len(ALPHAS), 1)), atol=1e-11)


def test_two_steps_in_a_row_are_one_of_their_sum() -> None:
    points, faces = random_mesh(50)
    walk = random_walk(points, unique_edges(faces))
    once = discrete_gaussian(walk, points, [5.0])[0]
    twice = discrete_gaussian(walk, once, [8.0])[0]
    np.testing.assert_allclose(twice, discrete_gaussian(walk, points, [13.0])[0], atol=1e-11)


def test_the_series_is_cut_within_the_tolerance() -> None:
    points, faces = random_mesh(50)
    walk = random_walk(points, unique_edges(faces))
    exact = discrete_gaussian(walk, points, ALPHAS)
    for tolerance in (1e-3, 1e-6, 1e-9):
        error = np.abs(discrete_gaussian(walk, points, ALPHAS, tolerance) - exact).max()
        assert error <= tolerance * np.linalg.norm(points)


def test_without_the_private_kernel_of_scipy_nothing_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    points, faces = random_mesh(50)
    walk = random_walk(points, unique_edges(faces))
    expected = discrete_gaussian(walk, points, ALPHAS)
    assert scale_space.csr_matvecs is not None
    monkeypatch.setattr(scale_space, "csr_matvecs", None)
    np.testing.assert_allclose(discrete_gaussian(walk, points, ALPHAS), expected, atol=1e-14)


def test_inputs_are_left_alone() -> None:
    points, faces = random_mesh(20)
    walk = random_walk(points, unique_edges(faces))
    points.flags.writeable = False
    before = walk.data.copy()
    discrete_gaussian(walk, points, ALPHAS)
    np.testing.assert_array_equal(walk.data, before)


@pytest.mark.shared
@pytest.mark.parametrize("name", REAL)
def test_a_real_mesh_equals_expm_multiply(shared_data: Path, name: str) -> None:
    welded = weld(read_packed(shared_data / name))
    edges = unique_edges(welded.faces)
    walk = random_walk(welded.points, edges)
    unit = welded.points / np.linalg.norm(np.ptp(welded.points, axis=0))
    alphas = 2.0 * (0.003 * np.arange(1, 7)) ** 2 / mean_squared_edge(unit, edges)
    generator = walk - eye_array(len(unit))
    expected = np.stack([expm_multiply(alpha * generator, unit) for alpha in alphas])
    np.testing.assert_allclose(discrete_gaussian(walk, unit, alphas), expected, rtol=0, atol=1e-9)


def random_mesh(size: int) -> tuple[FloatArray, np.ndarray[tuple[int, int], np.dtype[np.int64]]]:
    rng = np.random.default_rng(size)
    chain = np.stack([np.arange(size - 2), np.arange(1, size - 1), np.arange(2, size)], axis=1)
    return rng.normal(size=(size, 3)), np.concatenate([chain, rng.integers(0, size, (size, 3))])
