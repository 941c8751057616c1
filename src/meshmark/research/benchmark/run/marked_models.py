"""Marked models kept in a folder, so that no model is marked twice for the same purpose."""

from __future__ import annotations

import os
from dataclasses import astuple
from pathlib import Path

import numpy as np

from meshmark.mesh import Mesh
from meshmark.research.benchmark.run.job import Mark
from meshmark.research.benchmark.run.seeds import hashed

__all__ = ["MARKED", "clear_unfinished", "load_mark", "mark_path", "save_mark"]

# Name of the folder below the run's.
MARKED = "marked"
_UNFINISHED = ".tmp"


def mark_path(out: Path, mark: Mark) -> Path:
    """Return where the marked model is kept: a name that is a hash of all that it depends on."""
    return out / MARKED / f"{hashed('mark', *astuple(mark)).hex()[:32]}.npz"


def save_mark(out: Path, mark: Mark, mesh: Mesh) -> None:
    """Keep a marked model; the file is complete or not there, whenever the process ends."""
    path = mark_path(out, mark)
    path.parent.mkdir(exist_ok=True)
    unfinished = path.with_name(f"{path.stem}-{os.getpid()}{_UNFINISHED}")
    with unfinished.open("wb") as file:
        np.savez(file, vertices=mesh.vertices, faces=mesh.faces.astype(np.int32))
    unfinished.replace(path)


def load_mark(out: Path, mark: Mark) -> Mesh:
    """Return a marked model that was kept."""
    with np.load(mark_path(out, mark)) as held:
        return Mesh(held["vertices"], held["faces"].astype(np.int64))


def clear_unfinished(out: Path) -> None:
    """Remove what a killed process left half written."""
    for path in (out / MARKED).glob(f"*{_UNFINISHED}"):
        path.unlink(missing_ok=True)
