"""Models to train on: small ones as they are, larger ones simplified, each in its canonical frame."""

from __future__ import annotations

import numpy as np

from meshmark.attacks.chain import parse_chain
from meshmark.geometry.frame import canonical_frame
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.research.schemes.rivals.host import Host

__all__ = ["Example", "example"]

Example = tuple[FloatArray, IntArray]
"""Points (p, 3) in canonical coordinates and faces (m, 3)."""

# Fewer points are too few to train on; larger models are simplified to a number between these.
FEWEST, LEAST, MOST = 350, 400, 1600


def example(mesh: Mesh, rng: np.random.Generator) -> Example | None:
    """Return what to train on of a model, None where it is too small."""
    host = Host(mesh)
    wanted = np.exp(rng.uniform(np.log(LEAST), np.log(MOST)))
    if len(host.points) > wanted:
        host = Host(parse_chain(f"simplification:{1.0 - wanted / len(host.points):.4f}")(mesh, rng))
    if not FEWEST <= len(host.points) <= 2 * MOST:
        return None
    return canonical_frame(host.points, host.faces).to_canonical(host.points), host.faces
