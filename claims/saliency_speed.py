"""Saliency against the sparse products it contains and against the Laplace-Beltrami route.

    python -m claims.saliency_speed

For each model, in turns within one run and the best of several turns each:
products   the walk times an (n, 3) array, as often as the six scales need it (nothing else);
scales     the six scales of NC-DGG with the walk and the normals at hand: bar 1.3 times the products;
whole      edges, walk, areas, normals, six scales, beta: everything from points and faces;
spectral   the Laplace-Beltrami route: cotangent Laplacian and 50 eigenpairs by shift-invert `eigsh`:
           bar: whole at most 1/5 of it. Left out above SPECTRAL_LIMIT points (factors of many gigabytes).

No page quotes its figures yet; docs/claims.md says what it prints.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array
from scipy.sparse.linalg import eigsh

from claims.models import DATA, load
from meshmark.geometry.adjacency import mean_squared_edge, unique_edges
from meshmark.geometry.areas import vertex_areas, vertex_areas_and_normals
from meshmark.geometry.scale_space import random_walk, terms
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray
from meshmark.saliency.nc_dgg import EPSILON, SCALES, model_diagonal, saliency, tangent_distance

MODELS = (
    ("models/train/casting_5096.off.xz", 200),
    ("models/test/hand_50085.off.xz", 20),
    ("large/horse_loop2_775730.ply.xz", 3),
)
SPECTRAL_LIMIT = 100_000
EIGENPAIRS = 50


def products(walk: csr_array, values: FloatArray, count: int) -> FloatArray:
    for _ in range(count):
        values = walk @ values
    return values


def spectral(points: FloatArray, faces: IntArray) -> FloatArray:
    """Return the first eigenvalues and compute the vectors of the cotangent Laplacian."""
    laplacian = coo_array((len(points), len(points))).tocsr()
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        left, right = (points[faces[:, corner]] - points[faces[:, a]] for corner in (b, c))
        area = np.linalg.norm(np.cross(left, right), axis=1)
        half_cotangent = 0.5 * np.einsum("ij,ij->i", left, right) / np.maximum(area, 1e-300)
        edge = (faces[:, b], faces[:, c])
        laplacian = laplacian + coo_array((half_cotangent, edge), shape=laplacian.shape).tocsr()
    laplacian = laplacian + laplacian.T
    stiffness = diags_array(np.asarray(laplacian.sum(axis=1))) - laplacian
    mass = diags_array(np.maximum(vertex_areas(points, faces), 1e-12 * np.ptp(points) ** 2))
    values: FloatArray = eigsh(stiffness.tocsc(), EIGENPAIRS, mass.tocsc(), sigma=-0.01)[0]
    return values


def interleaved(turns: int, tasks: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Return the least processor time of each task, s; they take turns, so all meet the same weather."""
    best = dict.fromkeys(tasks, np.inf)
    for _ in range(turns):
        for name, task in tasks.items():
            for _ in range(3 if turns > 3 else 1):  # the first run after another task finds its data gone
                began = time.process_time()
                task()
                best[name] = min(best[name], time.process_time() - began)
    return best


def main() -> int:
    if not DATA.is_dir():
        print(f"left out: {DATA} is not on this machine")
        return 0
    row = "{:>9} {:>6} {:>12} {:>12} {:>12} {:>12} {:>9} {:>9} {:>9} {:>12}"
    heads = ("points", "terms", "products ms", "scales ms", "whole ms", "spectral ms")
    print(row.format(*heads, "scales/p", "whole/p", "whole/sp", "points/s"))
    good = True
    for name, turns in MODELS:
        welded = weld(load(DATA / name))
        points, faces = welded.points, welded.faces
        edges = unique_edges(faces)
        walk = random_walk(points, edges)
        areas, normals = vertex_areas_and_normals(points, faces)
        sigmas = EPSILON * model_diagonal(points, areas) * np.arange(1, SCALES + 1)
        alphas = 2.0 * sigmas**2 / mean_squared_edge(points, edges)
        count = terms(alphas) - 1
        tasks: dict[str, Callable[[], object]] = {
            "products": lambda w=walk, x=points, k=count: products(w, x, k),
            "scales": lambda w=walk, x=points, n=normals, a=alphas: tangent_distance(w, x, n, a),
            "whole": lambda p=points, f=faces: saliency(p, f),
        }
        best = interleaved(turns, tasks)
        slow = np.nan
        if len(points) <= SPECTRAL_LIMIT:
            slow = interleaved(1, {"spectral": lambda p=points, f=faces: spectral(p, f)})["spectral"]
        ratios = best["scales"] / best["products"], best["whole"] / best["products"], best["whole"] / slow
        times = [f"{1e3 * t:.1f}" for t in (*best.values(), slow)]
        rate = f"{len(points) / best['whole']:,.0f}"
        print(row.format(len(points), count + 1, *times, *(f"{r:.2f}" for r in ratios), rate), flush=True)
        good &= ratios[0] <= 1.3 and not ratios[2] > 0.2
    print("within the bars" if good else "outside a bar")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
