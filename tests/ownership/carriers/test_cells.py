from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.keys import Key
from meshmark.geometry.areas import area_vectors, vertex_normals
from meshmark.geometry.open_edges import sample_open_edges
from meshmark.geometry.sampling import Samples, plan_samples
from meshmark.ownership.carriers.cells import border_gradient, cell_gradient, measure_cells
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.nodes import find_nodes
from meshmark.ownership.carriers.selection import select_cells
from tests.counting import some
from tests.shapes import pebble

LABEL = Label(bytes(16))
KEY = Key(bytes(range(32)))


def placed_pebble(spacing: float = 0.3, across: int = 40):
    points, faces = pebble(across)
    return Lattice.keyed(KEY, spacing, LABEL).coordinates(points), faces


def brute_force(points, faces, node):
    """The statistic from its definition: a sum over all finely split faces, one cell at a time."""
    sampler = plan_samples(points, faces, 0.25)
    samples = sampler(points)
    arm = samples.positions - node
    window = np.clip(1.0 - (arm**2).sum(axis=1), 0.0, None) ** 3
    flux = window @ samples.vectors
    offset = (window * (arm * samples.vectors).sum(axis=1)).sum() / np.linalg.norm(flux)
    return offset, flux, np.linalg.norm(flux) / (window @ samples.areas)


def test_statistic_equals_its_definition_cell_by_cell():
    points, faces = placed_pebble()
    cells = measure_cells(plan_samples(points, faces, 0.25)(points))
    assert len(cells.nodes) > 300
    for i in some(range(0, len(cells.nodes), 7)):
        offset, flux, flatness = brute_force(points, faces, cells.nodes[i])
        assert cells.offset[i] == pytest.approx(offset, abs=1e-9)
        assert cells.mass[i] == pytest.approx(np.linalg.norm(flux) / (np.pi / 4))
        assert cells.flatness[i] == pytest.approx(flatness)
        np.testing.assert_allclose(cells.normal[i], flux / np.linalg.norm(flux), atol=1e-9)


def test_a_plane_has_the_offset_of_its_height_and_full_mass():
    grid = np.linspace(-4, 4, 161)
    x, y = (axis.ravel() for axis in np.meshgrid(grid, grid, indexing="ij"))
    cell = (grid[1] - grid[0]) ** 2
    height = 0.2
    samples = Samples(
        positions=np.column_stack([x, y, np.full_like(x, height)]),
        vectors=np.tile([0.0, 0.0, cell], (len(x), 1)),
        areas=np.full(len(x), cell),
    )
    cells = measure_cells(samples)
    centre = np.flatnonzero((cells.nodes == 0).all(axis=1))[0]
    assert cells.offset[centre] == pytest.approx(height)
    assert cells.mass[centre] == pytest.approx((1 - height**2) ** 4, rel=1e-4)  # window over a shifted plane
    assert cells.flatness[centre] == pytest.approx(1.0)


def test_gradient_predicts_the_change_under_a_smooth_displacement():
    points, faces = placed_pebble()
    sampler = plan_samples(points, faces, 0.25)
    samples = sampler(points)
    cells = measure_cells(samples)
    cells = cells.take(select_cells(cells, (0.35, 0.7, 0.5)))
    normals = vertex_normals(points, faces)
    lengths = 1e-4 * np.sin(points @ [1.0, 0.7, -0.4])
    after = measure_cells(sampler(points + lengths[:, None] * normals))
    change = after.offset[find_nodes(after.nodes, cells.nodes)] - cells.offset
    predicted = cell_gradient(samples, cells) @ sampler.normal_motion(samples, normals) @ lengths
    assert np.abs(change - predicted).max() < 0.06 * np.abs(change).max()


@pytest.mark.parametrize("surface", ["open", "soup", "one face turned over"])
def test_with_the_border_term_the_gradient_holds_for_open_surfaces(surface):
    points, faces = placed_pebble()
    faces = faces[points[faces].mean(axis=1)[:, 0] > points[:, 0].mean()]
    if surface == "soup":
        points, faces = points[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)
    elif surface == "one face turned over":
        faces = np.concatenate([faces[:-1], faces[-1:, ::-1]])
    sampler = plan_samples(points, faces, 0.25)
    samples = sampler(points)
    cells = measure_cells(samples)
    cells = cells.take(select_cells(cells, (0.35, 0.7, 0.5)))
    normals = vertex_normals(points, faces)
    lengths = 1e-5 * np.random.default_rng(4).normal(size=len(points))
    after = measure_cells(sampler(points + lengths[:, None] * normals))
    change = after.offset[find_nodes(after.nodes, cells.nodes)] - cells.offset
    faces_part = cell_gradient(samples, cells) @ sampler.normal_motion(samples, normals) @ lengths
    edges = sample_open_edges(points, faces, 0.25)
    border = sum(
        border_gradient(edges, np.eye(3)[axis], cells) @ (edges.motion @ (lengths * normals[:, axis]))
        for axis in range(3)
    )
    assert np.linalg.norm(faces_part + border - change) < 0.1 * np.linalg.norm(change)
    assert np.linalg.norm(faces_part - change) > np.linalg.norm(faces_part + border - change)


def test_refining_the_mesh_hardly_changes_the_statistic():
    points, faces = placed_pebble()
    coarse = measure_cells(plan_samples(points, faces, 0.25)(points))
    coarse = coarse.take(select_cells(coarse, (0.35, 0.7, 0.5)))
    fine = measure_cells(plan_samples(points, faces, 0.05)(points))
    change = fine.offset[find_nodes(fine.nodes, coarse.nodes)] - coarse.offset
    assert np.sqrt((change**2).mean()) < 0.003


def error_under_face_noise(across):
    points, faces = placed_pebble(across=across)
    vectors, middle = area_vectors(points, faces), points[faces].mean(axis=1)
    areas = np.linalg.norm(vectors, axis=1)
    still = measure_cells(Samples(positions=middle, vectors=vectors, areas=areas))
    noise = 0.5 * np.random.default_rng(3).normal(size=vectors.shape) * areas[:, None]
    rough = measure_cells(Samples(positions=middle, vectors=vectors + noise, areas=areas))
    chosen = select_cells(still, (0.35, 0.7, 0.5))
    return np.sqrt(((rough.offset - still.offset)[chosen] ** 2).mean())


def test_zero_mean_noise_of_the_area_vectors_averages_out_over_more_faces():
    assert error_under_face_noise(80) < 0.65 * error_under_face_noise(40)


def test_find_nodes_knows_what_is_gone():
    points, faces = placed_pebble()
    cells = measure_cells(plan_samples(points, faces, 0.25)(points))
    wanted = np.concatenate([cells.nodes[[5, 0, 9]], cells.nodes[:1] + 1000])
    assert find_nodes(cells.nodes, wanted).tolist() == [5, 0, 9, -1]


def test_outliers_and_areas_of_zero_cost_nothing():
    points, faces = placed_pebble()
    samples = plan_samples(points, faces, 0.25)(points)
    far = Samples(
        positions=np.concatenate([samples.positions, [[3e5, -3e5, 3e5], [1e300, 0, 0], [9e4, 0, 0]]]),
        vectors=np.concatenate([samples.vectors, np.ones((3, 3))]),
        areas=np.concatenate([samples.areas, [0.0, 1.0, 1.0]]),
    )
    one, other = measure_cells(samples), measure_cells(far)
    assert len(other.nodes) <= len(one.nodes) + 8
    np.testing.assert_allclose(other.offset[find_nodes(other.nodes, one.nodes)], one.offset, atol=1e-12)
