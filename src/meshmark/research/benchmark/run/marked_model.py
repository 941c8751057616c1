"""Before anything is judged: look at a model, and mark it."""

from __future__ import annotations

import tempfile
from dataclasses import fields
from functools import lru_cache
from pathlib import Path
from time import perf_counter

from meshmark.coding.keys import Key
from meshmark.errors import MeshmarkError
from meshmark.geometry.weld import weld
from meshmark.io import FORMATS, read_mesh, write_mesh
from meshmark.mesh import Mesh
from meshmark.metrics import compare
from meshmark.research import SCHEMES
from meshmark.research.benchmark.run.job import Look, Mark, Outcome
from meshmark.research.benchmark.run.marked_models import save_mark
from meshmark.research.benchmark.run.model_files import load, load_shipped, size_class
from meshmark.research.benchmark.run.row import Row
from meshmark.research.benchmark.run.seeds import bits_for, key_for
from meshmark.research.schemes.scheme import Bits

__all__ = ["key_of", "look", "mark", "original", "payload_of"]

# A worker keeps the last few models, whose cases follow each other.
_KEPT = 3
# A row has these of the distortions.
_FIGURES = {field.name for field in fields(Row)}


@lru_cache(maxsize=_KEPT)
def original(data: Path, model: str) -> Mesh:
    """Return a model as it is; raises `InputError` where it cannot be read."""
    return load(data / model)


def key_of(mark: Mark) -> Key:
    """Return the key of the owner of a mark: the same for the model, its copies and the donor."""
    return key_for(mark.seed, mark.scheme, mark.owner, mark.budget, mark.fresh)


def payload_of(mark: Mark, count: int) -> Bits:
    """Return the payload of a mark, (count,) uint8."""
    names = (mark.seed, mark.scheme, mark.owner, mark.budget, mark.fresh, mark.number, int(mark.donor))
    return bits_for(count, *names)


def look(data: Path, job: Look) -> Outcome:
    """Read a model and tell its size."""
    mesh = original(data, job.model)
    points = len(weld(mesh).points)
    figures = {"points": points, "size_class": size_class(points), "file_seconds": _file_seconds(mesh)}
    return Outcome(status="ok", figures=figures)


def _file_seconds(mesh: Mesh) -> float | None:
    """Return the time to write the model in its own format and to read that; None where it cannot be written."""
    extension = FORMATS[mesh.document.format if mesh.document else "ply"].extensions[0]
    with tempfile.TemporaryDirectory(prefix="meshmark-") as folder:
        start = perf_counter()
        try:
            write_mesh(mesh, Path(folder) / f"model{extension}")
            read_mesh(Path(folder) / f"model{extension}")
        except MeshmarkError:
            return None
        return perf_counter() - start


def mark(data: Path, out: Path, job: Mark) -> Outcome:
    """Mark a model and keep it; raises what the scheme raises.

    Figures: the time, and the distortion of a model's first mark; that of the others would say the same.
    """
    scheme = SCHEMES[job.scheme]
    mesh = load_shipped() if job.donor else original(data, job.owner)
    bits, key = payload_of(job, scheme.bits), key_of(job)
    start = perf_counter()
    marked = scheme.embed(mesh, bits, key, strength=job.budget)
    seconds = perf_counter() - start
    save_mark(out, job, marked)
    first = not (job.number or job.fresh or job.donor)
    distortion = compare(mesh, marked).to_dict() if first else {}
    kept = {name: value for name, value in distortion.items() if name in _FIGURES}
    return Outcome(status="ok", figures={**kept, "embed_seconds": seconds})
