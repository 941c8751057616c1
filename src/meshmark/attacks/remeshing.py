"""Isotropic remeshing: a new surface of nearly equilateral triangles, as sculpting programs make it."""

from __future__ import annotations

import io
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.manifold_pieces import manifold_pieces
from meshmark.attacks.optional_library import missing
from meshmark.errors import InputError
from meshmark.geometry.adjacency import unique_edges
from meshmark.geometry.areas import face_areas
from meshmark.geometry.weld import weld
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["remeshing"]

CHILD = Path(__file__).with_name("remeshing_child.py")
SECONDS = 150
MAX_FACES = 3_000_000


def remeshing(mesh: Mesh, strength: float, _rng: np.random.Generator, _given: Given) -> Attacked:
    """Remesh to edges of `strength` (0.2 to 5) times the mean edge length (Botsch and Kobbelt 2004, by gpytoolbox).

    The surface is cut along edges that other than two faces share, or whose faces disagree about their side; border
    points stay, so that the pieces fit together again. The library runs in a process of its own, which may crash or
    hang without harm to the caller. No vertex has an origin.

    Raises `InputError` for a strength out of range, a result of over 3 million faces, a model on which the library
    fails or takes over 150 s, and where gpytoolbox is missing.
    """
    if not 0.2 <= strength <= 5.0:
        raise InputError(f"strength {strength:g} is out of range, expected 0.2 to 5 mean edge lengths")
    if find_spec("gpytoolbox") is None:
        raise missing("gpytoolbox", "remesh")
    welded = weld(mesh)
    points, faces = manifold_pieces(welded.points, welded.faces)
    if not len(faces):
        raise InputError("the model has no faces to remesh, expected at least one")
    low, high = points.min(axis=0), points.max(axis=0)
    middle, scale = 0.5 * (low + high), float(np.linalg.norm(high - low))
    points = (points - middle) / scale
    ends = unique_edges(faces)
    edge = strength * float(np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1).mean())
    count = face_areas(points, faces).sum() / (np.sqrt(3.0) / 4.0 * edge**2)
    if count > MAX_FACES:
        raise InputError(f"{count:.0f} faces would be made, expected at most {MAX_FACES}: raise the strength")
    new_points, new_faces = _in_a_child(points, faces, edge)
    joined = weld(Mesh(new_points * scale + middle, new_faces))
    return Attacked(mesh=Mesh(joined.points, joined.faces), origin=None)


def _in_a_child(points: FloatArray, faces: IntArray, edge: float) -> tuple[FloatArray, IntArray]:
    sent = io.BytesIO()
    np.savez(sent, points=points, faces=faces, edge=edge, seconds=SECONDS)
    try:
        done = subprocess.run(
            [sys.executable, "-P", str(CHILD)], input=sent.getvalue(), capture_output=True, timeout=SECONDS
        )
    except subprocess.TimeoutExpired as error:
        raise InputError(
            f"the model takes over {SECONDS} s to remesh, expected a smaller or cleaner one"
        ) from error
    if done.returncode:
        said = done.stderr.decode(errors="replace").strip().splitlines()[-1:] or [f"exit {done.returncode}"]
        raise InputError(f"the library for remeshing fails on this model ({said[0]}), expected a cleaner one")
    with np.load(io.BytesIO(done.stdout)) as got:
        return got["points"], got["faces"]
