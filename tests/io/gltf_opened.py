"""Samples of glTF, read from each of the shells a file can have."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from meshmark.io.gltf.parse import GltfDocument, parse_glb, parse_gltf
from tests.io.gltf_samples import Sample

SHELLS = ("glb", "embedded", "external")


def opened(sample: Sample, shell: str, folder: Path) -> tuple[GltfDocument, bytes, str]:
    """Return the document of a sample in one of the shells, its bytes, and a name to save it under."""
    if shell == "glb":
        data = sample.glb()
        return parse_glb(data, folder / "in.glb"), data, "out.glb"
    data = sample.embedded() if shell == "embedded" else sample.external(folder)
    return parse_gltf(data, folder / "in.gltf"), data, "out.gltf"


def moved(document: GltfDocument, seed: int = 1) -> Any:
    """Return the vertices, each pushed by about a thousandth of the model."""
    size = np.ptp(document.vertices, axis=0).max()
    return document.vertices + np.random.default_rng(seed).normal(size=document.vertices.shape) * size * 1e-3
