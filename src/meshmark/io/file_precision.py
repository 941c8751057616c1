"""The precision of a mesh's file."""

from __future__ import annotations

from meshmark.mesh import FloatArray, Mesh

__all__ = ["conform"]


def conform(mesh: Mesh, vertices: FloatArray) -> FloatArray:
    """Return the positions that the mesh's file would hold, after its own precision, for these.

    Parameters
    ----------
    mesh : Mesh
        A mesh of n vertices; one made in memory holds any double.
    vertices : (n, 3) array of float
        Positions to be saved.

    Returns
    -------
    (n, 3) array of float
        The same positions after a save and another reading.
    """
    return vertices.copy() if mesh.document is None else mesh.document.conform(vertices)
