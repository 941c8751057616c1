"""MSDM2 against the reference values, a second implementation in plain loops, and what must hold."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh

from meshmark.errors import InputError
from meshmark.geometry.closest_point import SurfaceIndex
from meshmark.mesh import Mesh
from meshmark.metrics import msdm2 as module
from meshmark.metrics.msdm2 import msdm2, msdm2_map, msdm2_symmetric
from tests.packed import read_packed
from tests.shapes import pebble

PEBBLE = Mesh(*pebble(24))


def rough(mesh: Mesh, by: float, seed: int = 0) -> Mesh:
    return mesh.with_vertices(
        mesh.vertices + by * np.random.default_rng(seed).normal(size=mesh.vertices.shape)
    )


def grow(points, neighbours, centre, radius):
    """Yield (start, end, share) of all edges followed, share of it inside the sphere; None for points."""
    reached, stack = {centre}, [centre]
    while stack:
        start = stack.pop()
        yield start, None, None
        for end in neighbours[start]:
            step, offset = points[end] - points[start], points[start] - points[centre]
            if start != centre and step @ offset <= 0.0:
                continue
            if np.linalg.norm(points[end] - points[centre]) > radius:
                foot, length = -(step @ offset) / (step @ step), np.linalg.norm(step)
                aside = np.linalg.norm(offset + foot * step)
                yield start, end, foot + np.sqrt(radius**2 - aside**2) / length
            else:
                yield start, end, 1.0
                if end not in reached:
                    reached.add(end)
                    stack.append(end)


def plain_curvature(points, model, radius):
    """Half the sum of principal curvatures' magnitudes, from trimesh's adjacency and angles."""
    pairs = {}
    for (p, q), (f, g) in zip(model.face_adjacency_edges, model.face_adjacency, strict=True):
        turn = np.cross(model.face_normals[f], model.face_normals[g]) @ (points[q] - points[p])
        angle = np.arcsin(np.clip(turn / np.linalg.norm(points[q] - points[p]), -1, 1))
        face = list(model.faces[f])
        sign = 1.0 if face[(face.index(p) + 1) % 3] == q else -1.0
        pairs[p, q] = pairs[q, p] = sign * angle
    out = np.zeros(len(points))
    for centre in range(len(points)):
        tensor = np.zeros((3, 3))
        for start, end, share in grow(points, model.vertex_neighbors, centre, radius):
            if end is not None:
                step = points[end] - points[start]
                tensor += pairs.get((start, end), 0.0) * share * np.outer(step, step) / np.linalg.norm(step)
        values = np.sort(np.abs(np.linalg.eigvalsh(tensor)))
        out[centre] = values[1:].sum() / (2 * np.pi * radius**2)
    return out


def plain_map(a: Mesh, b: Mesh):
    """MSDM2 from its definition, vertex by vertex."""
    longest = np.ptp(b.vertices, axis=0).max()
    models = [trimesh.Trimesh(m.vertices, m.faces, process=False) for m in (a, b)]
    points, near = b.vertices, SurfaceIndex(a.vertices, a.faces).nearest(b.vertices)
    corners = a.faces[near.faces]
    local = np.zeros(len(points))
    for part in (0.002, 0.003, 0.004):
        radius = part * longest
        theirs, own = (longest * plain_curvature(m.vertices, m, radius) for m in models)
        areas = np.array(
            [[np.linalg.norm(np.cross(*np.delete(a.vertices[t], i, 0) - q)) for i in range(3)]
             for q, t in zip(points, corners, strict=True)]
        )  # fmt: skip
        matched = (theirs[corners] * areas).sum(axis=1) / areas.sum(axis=1)
        for centre in range(len(points)):
            x, y, w, v = [], [], [], []
            for p, q, t in grow(points, models[1].vertex_neighbors, centre, 5 * radius):
                if q is not None and t == 1.0:
                    continue
                q, t = (p, 0.0) if q is None else (q, t)
                x.append((1 - t) * own[p] + t * own[q])
                y.append((1 - t) * matched[p] + t * matched[q])
                for weights, where in ((w, points), (v, near.points)):
                    apart = np.linalg.norm((1 - t) * where[p] + t * where[q] - where[centre])
                    weights.append(np.exp(-0.5 * (apart / (2.5 * radius)) ** 2))
            x, y, w, v = map(np.array, (x, y, w, v))
            mx, my = np.average(x, weights=w), np.average(y, weights=v)
            sx, sy = (
                np.sqrt(np.average((x - mx) ** 2, weights=w)),
                np.sqrt(np.average((y - my) ** 2, weights=v)),
            )
            cov = (v * (x - mx) * (y - my)).sum() / w.sum()
            terms = (
                abs(mx - my) / (max(mx, my) + 1),
                abs(sx - sy) / (max(sx, sy) + 1),
                abs(sx * sy - cov) / (sx * sy + 1),
            )
            local[centre] += (terms[0] + terms[1] + 0.5 * terms[2]) / 2.5 / 3
    return local


def test_as_a_second_implementation_in_plain_loops():
    fine = trimesh.creation.icosphere(subdivisions=2)
    patch = np.array(fine.vertices) * [1.0, 0.8, 0.6] * 0.014
    # a small ball beside a far triangle: the windows then hold many of its points
    far = np.array([[1.0, 0, 0], [1, 0.01, 0], [1, 0, 0.01]])
    faces = np.vstack([fine.faces, [[len(patch), len(patch) + 1, len(patch) + 2]]])
    a = rough(Mesh(np.vstack([patch, far]), faces), 5e-5, seed=1)
    b = rough(a, 1e-4, seed=2)
    plain = plain_map(a, b)
    assert plain.max() > 0.1
    assert msdm2_map(a, b) == pytest.approx(plain, abs=1e-9)
    assert msdm2(a, b) == pytest.approx(np.cbrt((plain**3).mean()), abs=1e-9)


def test_a_similar_model_looks_the_same():
    a, b = PEBBLE, rough(PEBBLE, 0.01)
    turned = [m.with_vertices(7.0 * m.vertices[:, [1, 2, 0]] + [5.0, -3.0, 2.0]) for m in (a, b)]
    assert msdm2(*turned) == pytest.approx(msdm2(a, b), rel=3e-3)  # but for ties of closest points


def test_direction_and_symmetry():
    a, b = PEBBLE, Mesh(*pebble(20))
    there, back = msdm2(a, b), msdm2(b, a)
    assert there != back
    assert msdm2_symmetric(a, b) == (there + back) / 2 == msdm2_symmetric(b, a)


def test_coincident_vertices_are_one_point():
    b = rough(PEBBLE, 0.01)
    soup = Mesh(b.vertices[b.faces].reshape(-1, 3), np.arange(b.faces.size).reshape(-1, 3))
    assert msdm2(PEBBLE, soup) == pytest.approx(msdm2(PEBBLE, b), abs=1e-12)
    assert msdm2_map(PEBBLE, soup) == pytest.approx(msdm2_map(PEBBLE, b)[b.faces.ravel()], abs=1e-12)


def test_broken_places_count_as_no_curvature():
    """A flap with three faces on an edge, a face without area, a loose vertex, a hole, a face turned over."""
    points, faces = pebble(24)
    flap = np.array([[*faces[100, :2], len(points)]])
    flat = np.array([[*faces[30, :2], faces[30, 0]], [*faces[50, :2], len(points) + 2]])
    middle = points[faces[50, :2]].mean(axis=0)
    points = np.vstack([points, [[2.0, 2, 2], [3, 3, 3]], [middle]])
    faces = np.vstack([faces[5:], flap, flat])
    faces[7] = faces[7, ::-1]
    a = Mesh(points, faces)
    b = rough(a, 0.01)
    found = msdm2_map(a, b)
    assert found.shape == (len(points),)
    assert (found >= 0).all()
    assert (found <= 1).all()
    assert found[len(points) - 2] == 0.0, "a loose vertex is no surface"
    assert 0.0 < msdm2(a, b) < 1.0
    assert msdm2(a, a) == 0.0


def test_many_points_are_judged_by_some_of_them(monkeypatch):
    a, b = PEBBLE, rough(PEBBLE, 0.01)
    every = msdm2(a, b)
    monkeypatch.setattr(module, "MOST_WINDOWS", 200)
    monkeypatch.setattr(module, "SOME_WINDOWS", 100)
    assert msdm2(a, b) == pytest.approx(every, rel=0.05)
    assert len(msdm2_map(a, b)) == len(b.vertices)


def test_what_has_no_surface_is_refused():
    dots = Mesh(PEBBLE.vertices, np.zeros((0, 3), int))
    line = Mesh(PEBBLE.vertices, np.array([[0, 1, 1]]))
    for a, b in ((PEBBLE, dots), (line, PEBBLE)):
        with pytest.raises(InputError, match="no triangle"):
            msdm2(a, b)


@pytest.mark.shared
@pytest.mark.parametrize(
    ("pair", "tolerance"),
    [("bimba", 3e-4), ("cow_smooth30", 2e-3), ("cow_simp50", 2e-3)],
)
def test_the_reference_values(shared_data, pair, tolerance):
    """All nine pairs: python -m claims.metrics_validation."""
    folder = shared_data / "msdm2"
    values = json.loads((folder / "values.json").read_text())[pair]
    a, b = (read_packed(folder / values[name]) for name in ("original", "degraded"))
    assert msdm2(a, b) == pytest.approx(values["msdm2"], abs=tolerance)
    assert msdm2(b, a) == pytest.approx(values["msdm2_reverse"], abs=tolerance)


@pytest.mark.shared
def test_the_reference_map_of_bimba_and_what_leads_to_it(shared_data):
    """Most vertices agree to rounding; closest points on an edge or corner may name either face."""
    from meshmark.geometry.curvature_tensor import principal_curvatures
    from meshmark.geometry.growth import half_edges

    folder = shared_data / "msdm2"
    a = read_packed(folder / "bimba_original.off.xz")
    b = read_packed(folder / "bimba_deformed.obj.xz")
    for x, y, name in ((a, b, ""), (b, a, "_reverse")):
        apart = np.abs(msdm2_map(x, y) - np.load(folder / f"bimba_msdm2{name}_pervertex.npy"))
        assert np.median(apart) < 1e-12
        assert np.quantile(apart, 0.9) < 1e-3
        assert np.quantile(apart, 0.99) < 0.02
    known = np.load(folder / "bimba_intermediates.npz")
    longest = np.ptp(b.vertices, axis=0).max()
    radii = tuple(part * longest for part in (0.002, 0.003, 0.004))
    for mesh, name in ((a, "curv_original"), (b, "curv_degraded")):
        graph = half_edges(mesh.vertices, mesh.faces)
        found = longest * principal_curvatures(mesh.vertices, mesh.faces, graph, radii)
        assert found.transpose(1, 0, 2).reshape(-1, 6) == pytest.approx(known[name], rel=1e-9, abs=1e-9)
    nearest = SurfaceIndex(a.vertices, a.faces).nearest(b.vertices)
    assert nearest.points == pytest.approx(known["nearest_point"], abs=1e-14)
