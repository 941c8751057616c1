"""From a file to a marked file that was read back before it took its name."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np

from meshmark.authentication.payload.content import Content
from meshmark.coding.keys import Key
from meshmark.geometry.surface_of import surface_of_moved
from meshmark.io import Staging, check_extension, check_recompression, read_mesh, uncompressed, write_mesh
from meshmark.io.formats import format_of_name
from meshmark.io.source import SourceFile
from meshmark.marking.both_layers import embed_for
from meshmark.marking.embedding_result import Embedding
from meshmark.marking.mark_request import MarkRequest
from meshmark.marking.undo import sealed
from meshmark.marking.verification import verify
from meshmark.mesh import Mesh

__all__ = ["embed_file"]


def embed_file(
    model: str | Path | Mesh,
    out: str | Path,
    key: Key,
    *,
    id: int | None = None,
    bits: int = 64,
    strength: str = "standard",
    layers: str | None = None,
    payload: Content = None,
    tolerance: str | None = None,
    recompress: bool = False,
    staging: Staging | None = None,
) -> Embedding:
    """Mark a model file and write the result, verified, to another file.

    The complete files are written under temporary names and read again, all layers blind; only then do they take
    their places.

    Parameters
    ----------
    model : path or Mesh
        The model file, or what was read from one.
    out : path
        The marked file; its extension says its format.
    key : Key
    id, bits, strength, layers, payload, tolerance
        As in `embed`.
    recompress : bool
        Write a compressed glTF compressed as it was, not uncompressed with a remark.
    staging : Staging, optional
        Takes the files, to move them into place together with others.

    Returns
    -------
    Embedding
        Its `seconds` count all of it.

    Raises
    ------
    InputError, FormatError, OutputError
        As reading, `embed` and writing raise them.
    CapacityError
        As `embed`, and where a layer is not found in the written file (a target format too coarse for the mark);
        nothing is left behind then.
    """
    start = perf_counter()
    mesh = model if isinstance(model, Mesh) else read_mesh(model)
    source = mesh.document.path if isinstance(mesh.document, SourceFile) else None
    check_extension(Path(out), source)
    if recompress:
        check_recompression(mesh, Path(out))
    request = MarkRequest.checked(
        key, id=id, bits=bits, strength=strength, layers=layers, payload=payload, tolerance=tolerance
    )
    result = embed_for(mesh, request, _goes_to(mesh, Path(out)))
    seen: list[Mesh] = []

    def read_back(written: Path) -> None:
        seen.append(read_mesh(written))
        if _same(seen[0], result.mesh):  # `embed` has checked these very positions
            surface_of_moved(seen[0], result.mesh)  # the same surface, remembered for the certificate
        else:
            verify(seen[0], key, result, Path(out).name, compressed=recompress)

    report = write_mesh(result.mesh, out, verify=read_back, recompress=recompress, staging=staging)
    remarks = result.remarks + uncompressed(report, Path(out))
    if mesh.document is not None:
        name = "the model" if source is None else source.name
        remarks = tuple(f"{name}: {remark}" for remark in mesh.document.remarks) + remarks
    if report.dropped:
        remarks += (f"{Path(out).name} cannot hold the model's {', '.join(report.dropped)}",)
    result = _as_written(result, mesh, seen[0], request)
    return replace(result, seconds=perf_counter() - start, remarks=remarks)


def _goes_to(mesh: Mesh, out: Path) -> str | None:
    """Return the format of the file to be written: that of its name, else that of the input."""
    named = format_of_name(out)
    if named is not None:
        return named.name
    return None if mesh.document is None else mesh.document.format


def _as_written(result: Embedding, original: Mesh, written: Mesh, request: MarkRequest) -> Embedding:
    """Return the result with the certificate of the written file; no undo data where its vertices differ."""
    same = original.vertices.shape == written.vertices.shape and np.array_equal(original.faces, written.faces)
    seal = partial(
        sealed, original=original if same else None, marked=written, key=request.key, identity=request.id
    )
    return replace(result, seal=seal)


def _same(mesh: Mesh, other: Mesh) -> bool:
    return np.array_equal(mesh.vertices, other.vertices) and np.array_equal(mesh.faces, other.faces)
