"""Several meshes as one graph, in PyTorch, and the network's inputs with their gradient."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from scipy.sparse import csr_array

from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.mesh import FloatArray, IntArray
from meshmark.research.schemes.rivals.deep3d.inputs import CLIP, mean_of_neighbours, wave_number, waves

__all__ = ["Batch"]


class _Product(torch.autograd.Function):
    """A sparse matrix, which is constant, times features."""

    @staticmethod
    def forward(ctx: Any, features: Any, matrix: csr_array, transposed: csr_array) -> Any:
        ctx.transposed = transposed
        return torch.from_numpy(matrix @ features.detach().numpy())

    @staticmethod
    def backward(ctx: Any, gradient: Any) -> Any:
        return torch.from_numpy(ctx.transposed @ gradient.contiguous().numpy()), None, None


class Batch:
    """Meshes, as lists of points (p, 3) and faces (m, 3), as one.

    points: tensor (n, 3); of: tensor (n,), the row of the mesh that each point belongs to; count: of meshes.
    """

    def __init__(self, meshes: Sequence[tuple[FloatArray, IntArray]]) -> None:
        sizes = [len(points) for points, _ in meshes]
        firsts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
        faces = np.concatenate([faces + first for (_, faces), first in zip(meshes, firsts, strict=True)])
        places = np.concatenate([points for points, _ in meshes])
        self._fill(places, faces, np.repeat(np.arange(len(meshes)), sizes), len(meshes))

    def _fill(self, places: FloatArray, faces: IntArray, of: IntArray, count: int) -> None:
        self.points = torch.from_numpy(places.astype(np.float32))
        self.faces, self.of, self.count = torch.from_numpy(faces), torch.from_numpy(of), count
        self.matrix = mean_of_neighbours(adjacency(unique_edges(faces), len(places)))
        self._transposed = csr_array(self.matrix.T)
        self.edges = torch.from_numpy(unique_edges(faces))
        self.sizes = torch.bincount(self.of, minlength=count).float()
        self._waves = torch.from_numpy(waves().astype(np.float32))
        self._wave_numbers = torch.tensor([wave_number(int(size)) for size in self.sizes])

    def part(self, kept: Any) -> Batch:
        """Return the batch of the points that are kept, tensor (n,) of bool, and the faces between them."""
        number = torch.cumsum(kept, 0) - 1
        faces = number[self.faces[kept[self.faces].all(dim=1)]]
        other = Batch.__new__(Batch)
        other._fill(self.points[kept].numpy(), faces.numpy(), self.of[kept].numpy(), self.count)
        return other

    def mean(self, features: Any) -> Any:
        """Return the means (n, c) over the neighbours of each point."""
        return _Product.apply(features, self.matrix, self._transposed)

    def pooled(self, features: Any) -> Any:
        """Return the means (meshes, c) over the points of each mesh."""
        sums = torch.zeros(self.count, features.shape[1]).index_add(0, self.of, features)
        return sums / self.sizes[:, None]

    def normals(self, points: Any) -> Any:
        """Return unit normals (n, 3) of the points at these places."""
        a, b, c = points[self.faces].unbind(dim=1)
        vectors = torch.linalg.cross(b - a, c - a)
        sums = torch.zeros_like(points)
        for corner in range(3):
            sums = sums.index_add(0, self.faces[:, corner], vectors)
        return sums / (sums.norm(dim=1, keepdim=True) + 1e-12)

    def heights(self, points: Any, normals: Any) -> tuple[Any, Any]:
        """Return how far each point (n,) is out of the mean of its neighbours, and the mean of it for each mesh."""
        out = ((points - self.mean(points)) * normals).sum(dim=1, keepdim=True)
        out = (out - self.mean(out))[:, 0]
        return out, self.pooled(out.detach().abs()[:, None])[:, 0] + 1e-9

    def curvature(self, points: Any) -> Any:
        """Return at each point (n,) the sum over its neighbours of cos(normal, edge): what the loss keeps."""
        normals = self.normals(points)
        start, end = self.edges.unbind(dim=1)
        steps = points[end] - points[start]
        steps = steps / (steps.norm(dim=1, keepdim=True) + 1e-9)
        sums = torch.zeros(len(points)).index_add(0, start, (normals[start] * steps).sum(dim=1))
        return sums.index_add(0, end, -(normals[end] * steps).sum(dim=1))

    def inputs(self, points: Any) -> Any:
        """Return the network's inputs (n, d) with these places; see `inputs.shown`."""
        normals = self.normals(points.detach())
        out, height = self.heights(points, normals)
        squashed = CLIP * torch.tanh(out / (CLIP * height[self.of]))
        phases = points @ self._waves * self._wave_numbers[self.of][:, None]
        return torch.cat([points, normals, squashed[:, None], torch.sin(phases), torch.cos(phases)], dim=1)
