"""From a file to a marked file that was read back before it took its name."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np

from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.geometry.shown import Shown
from meshmark.geometry.weld import Welded
from meshmark.io import read_mesh, write_mesh
from meshmark.mesh import Mesh
from meshmark.schemes.ncdg_lv.authentication.content import Content
from meshmark.schemes.ncdg_lv.extraction import extract
from meshmark.schemes.ncdg_lv.layers import embed, still_authentic
from meshmark.schemes.ncdg_lv.results import Embedding
from meshmark.schemes.ncdg_lv.surfaces import marked_surface, repeated, unfolded
from meshmark.schemes.ncdg_lv.undo import sealed

__all__ = ["embed_file"]


def embed_file(
    model: str | Path,
    out: str | Path,
    key: Key,
    id: int | None = None,
    strength: str = "standard",
    layers: str | None = None,
    payload: Content = None,
    tolerance: str | None = None,
) -> Embedding:
    """Mark the model file `model` and write the result to `out`; see `embed` for the arguments.

    The complete files are written under temporary names and read again, all layers blind; only then do they
    take their places; `seconds` counts all of it. Raises what reading, embedding and writing raise, and
    `CapacityError` where a layer is not found in the written file (a target format too coarse for the mark);
    nothing is left behind then.
    """
    start = perf_counter()
    mesh = read_mesh(model)
    result = embed(mesh, key, id=id, strength=strength, layers=layers, payload=payload, tolerance=tolerance)
    seen: list[Mesh] = []

    def read_back(written: Path) -> None:
        seen.append(read_mesh(written))
        _check(seen[0], key, result, Path(out).name)

    report = write_mesh(result.mesh, out, verify=read_back)
    remarks = result.remarks
    if report.dropped:
        remarks += (f"{Path(out).name} cannot hold the model's {', '.join(report.dropped)}",)
    result = _as_written(result, mesh, seen[0], key)
    return replace(result, seconds=perf_counter() - start, remarks=remarks)


def _check(written: Mesh, key: Key, result: Embedding, name: str) -> None:
    too_coarse = f"cannot be read back from {name}, whose format holds positions too coarsely"
    if result.layers != "authentication" and extract(written, key).id != result.id:
        raise CapacityError(f"the id {too_coarse}; use --strength strong or the format of the input")
    known = result.layers == "both"
    if result.layers != "ownership" and not any(
        still_authentic(surface, key, result.id, known=known) for surface in _surfaces(written)
    ):
        raise CapacityError(
            f"the marks of authentication {too_coarse}; use --tolerance tolerant or the format of the input"
        )


def _surfaces(written: Mesh) -> Iterator[Welded]:
    """Yield the surface that carries the marks, last with copies that its file does not tell put on their first."""
    first = marked_surface(written)
    yield first
    if not isinstance(first, Shown):
        yield from (unfolded(written, copies) for copies in repeated(written))


def _as_written(result: Embedding, original: Mesh, written: Mesh, key: Key) -> Embedding:
    """Return the result with the certificate of the written file; no undo data where its vertices differ."""
    same = original.vertices.shape == written.vertices.shape and np.array_equal(original.faces, written.faces)
    seal = partial(sealed, original=original if same else None, marked=written, key=key, identity=result.id)
    return replace(result, seal=seal)
