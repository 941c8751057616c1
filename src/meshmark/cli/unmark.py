"""`meshmark unmark`: take a mark off again."""

from __future__ import annotations

from math import ceil, floor, log10
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from meshmark.cli.model_input import named, read_model
from meshmark.cli.options import (
    AsJson,
    CertificateNeeded,
    ForceKeyed,
    KeyFile,
    ModelFormatIn,
    ModelIn,
    ModelOut,
)
from meshmark.cli.output import answer, described, percent, say
from meshmark.cli.paths import naming, staged, written_beside
from meshmark.cli.progress import progress
from meshmark.errors import InputError

if TYPE_CHECKING:
    from meshmark.coding.keys import Key
    from meshmark.mesh import Mesh

__all__ = ["unmark"]


def unmark(
    *,
    model: ModelIn,
    out: ModelOut,
    key: KeyFile,
    certificate: CertificateNeeded,
    format: ModelFormatIn = None,
    force: ForceKeyed = False,
    as_json: AsJson = False,
) -> int:
    """Take a mark off again, with the key and the certificate.

    The model must have its vertices in the order in which it was marked; it may have been turned, resized and
    moved. From a model that was not changed otherwise the original comes back.
    """
    from meshmark.coding.keys import Key
    from meshmark.io import check_extension, uncompressed, write_mesh

    start = perf_counter()
    staging = staged([(out, None)], [model, key, certificate], force)
    check_extension(out, model)
    secret = Key.load(key, force=force)
    mesh = read_model(model, format, staging)
    from meshmark.marking import Certificate
    from meshmark.marking import unmark as take_off

    kept = Certificate.load(certificate)
    with progress("taking the mark off"), naming(named(model)), staging:
        found = take_off(mesh, secret, kept)
        near = f"the original within {_up(found.within_over_diagonal)} of the diagonal"
        whole = near if found.exact else _told(named(model), mesh, secret, near)
        report = write_mesh(found.mesh, out, staging=staging)
    for remark in uncompressed(report, out):
        say(f"meshmark: {remark}")
    if report.dropped:
        say(f"meshmark: {out.name} cannot hold the model's {', '.join(report.dropped)}")
    moved = f"moved {percent(found.rms_over_diagonal)} of the diagonal RMS"
    words = f"Unmarked: {named(model)} -> {out}, {whole}; {moved}"
    fields = {
        "exact": found.exact,
        "within_over_diagonal": found.within_over_diagonal,
        "rms_over_diagonal": found.rms_over_diagonal,
        "side_files": written_beside(staging, [out]),
        "seconds": perf_counter() - start,
    }
    answer(words, described(fields, model, {"model": out}, secret), as_json)
    return 0


def _up(value: float) -> str:
    """Return two digits of a bound that is above 0, rounded up: 2.21e-7 is "2.3e-07"."""
    unit = 10.0 ** (floor(log10(value)) - 1)
    return f"{ceil(value / unit) * unit:.1e}"


def _told(path: Path, mesh: Mesh, key: Key, near: str) -> str:
    """Say what a model is that is not quite the marked one; raises `InputError` where no mark is there."""
    from meshmark.authentication.examination import examine

    found = examine(mesh, key)
    if found.id is None:
        raise InputError(f"{path.name} carries no mark of this key, so there is none to take off")
    if found.marked and not found.altered.any():
        return f"{near} and this copy's rounding, as it lies"
    return "but the model was changed since it was marked"
