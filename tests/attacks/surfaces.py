"""What tests ask of surfaces, by means of their own."""

from __future__ import annotations

from collections import Counter

import numpy as np

from meshmark.mesh import FloatArray, Mesh


def directed(mesh: Mesh) -> Counter[tuple[int, int]]:
    """Count how often each directed edge is walked."""
    walked: Counter[tuple[int, int]] = Counter()
    for a, b, c in mesh.faces.tolist():
        walked.update([(a, b), (b, c), (c, a)])
    return walked


def is_closed(mesh: Mesh) -> bool:
    """Whether each edge has exactly two faces, which walk it in opposite directions."""
    walked = directed(mesh)
    return all(count == 1 and walked[b, a] == 1 for (a, b), count in list(walked.items()))


def border(mesh: Mesh) -> set[frozenset[int]]:
    """Return the edges of one face only."""
    count = Counter(frozenset(edge) for edge in directed(mesh).elements())
    return {edge for edge, times in count.items() if times == 1}


def euler(mesh: Mesh) -> int:
    """Return points - edges + faces."""
    edges = {frozenset(edge) for edge in directed(mesh)}
    return len(np.unique(mesh.faces)) - len(edges) + len(mesh.faces)


def volume(mesh: Mesh) -> float:
    """Return the enclosed volume, positive where normals point outwards."""
    return float(np.linalg.det(mesh.vertices[mesh.faces]).sum()) / 6.0


def area(mesh: Mesh) -> float:
    """Return the area of the surface."""
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2.0


def unwelded(mesh: Mesh) -> Mesh:
    """Return the mesh with a vertex of its own for each corner, as STL files have it."""
    return Mesh(mesh.vertices[mesh.faces.ravel()], np.arange(mesh.faces.size).reshape(-1, 3))


def sheet(across: int, lean: bool = True) -> tuple[FloatArray, np.ndarray]:
    """Return points and faces of a flat rhombus of equilateral triangles, (across + 1)^2 points, z = 0."""
    i, j = (index.ravel() for index in np.meshgrid(np.arange(across + 1), np.arange(across + 1)))
    points = np.stack([i + 0.5 * j * lean, j * np.sqrt(0.75), 0.0 * i], axis=1)
    low = (np.arange(across)[:, None] * (across + 1) + np.arange(across)).ravel()
    up = np.stack([low, low + 1, low + across + 1], axis=1)
    down = np.stack([low + 1, low + across + 2, low + across + 1], axis=1)
    return points, np.concatenate([up, down])
