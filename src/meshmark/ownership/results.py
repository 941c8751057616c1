"""What embedding and extraction return; `to_dict` is the JSON of the command line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from math import inf
from typing import Any

from meshmark.certificate.certificate import Certificate, certify
from meshmark.coding.message import format_id
from meshmark.mesh import Mesh

__all__ = ["Embedding", "Evidence", "Extraction"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Embedding:
    """A marked mesh and how it came out.

    id: the 64-bit id; layers: what was embedded; vertices, faces: of the file; carriers: cells that an
    extraction reads; rms_over_diagonal, max_over_diagonal: vertex displacement over the bounding-box diagonal;
    psnr_db: 20 log10(diagonal / RMS), infinite where nothing moved (null in JSON);
    verified: the positions as the file holds them were decoded again.
    strength, spacing, step: of the lattice, as in `certificate`, which is made when it is asked for.
    remarks: sentences about how the file was read, what was left out, and what a conversion dropped.
    seal: adds to the certificate what takes the mark off again.
    repeated_only: the id lies in that part of the scene alone which is shown more than once.
    """

    mesh: Mesh
    id: int
    layers: str
    vertices: int
    faces: int
    carriers: int
    mark_vertices: int
    payload_bytes: int
    rms_over_diagonal: float
    max_over_diagonal: float
    psnr_db: float
    verified: bool
    seconds: float
    strength: str
    spacing: float
    step: float
    remarks: tuple[str, ...] = ()
    seal: Callable[[Certificate], Certificate] | None = field(default=None, repr=False)
    repeated_only: bool = False

    @cached_property
    def certificate(self) -> Certificate:
        """What to keep of the marked model, so that its mark is found in a damaged copy, or taken off again."""
        made = certify(self.mesh, self.spacing, self.step, self.strength, repeated_only=self.repeated_only)
        made = replace(made, more={**made.more, "layers": self.layers})
        return made if self.seal is None else self.seal(made)

    def to_dict(self) -> dict[str, Any]:
        """Return the fields without the mesh, the id in hexadecimal."""
        return _plain(self)


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What one layer of a model says.

    layer: "cells" (the ownership layer) or "authentication"; id: the 64-bit id, None where there is a mark whose id
    cannot be read. log10_false_positive: bound on the chance of this without a mark of this key.
    """

    layer: str
    id: int | None
    log10_false_positive: float

    def to_dict(self) -> dict[str, Any]:
        """Return the fields, the id in hexadecimal."""
        identity = None if self.id is None else format_id(self.id)
        return {"layer": self.layer, "id": identity, "log10_false_positive": self.log10_false_positive}


@dataclass(frozen=True, eq=False, kw_only=True)
class Extraction:
    """What was read from a mesh.

    presence: "present", "absent" or "inconclusive"; id: the 64-bit id or None.
    log10_false_positive: bound on the chance of this answer without a mark of this key, over all that was tried.
    mode: "blind", "certificate" or "original". carriers: cells read; carriers_agreeing: those whose bit is the
    decoded one's.
    lock_score: mean cos(2 phase), 1 for an untouched mark and about 0 without one.
    advice: one sentence for the reader. evidence: what layers say of a mark, none where it is absent.
    """

    presence: str
    id: int | None
    log10_false_positive: float
    mode: str
    carriers: int
    carriers_agreeing: int
    lock_score: float
    advice: str
    seconds: float
    evidence: tuple[Evidence, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the fields, the id in hexadecimal."""
        return _plain(self)


def _plain(result: Embedding | Extraction) -> dict[str, Any]:
    names = [entry.name for entry in fields(result) if entry.name not in ("mesh", "seal", "repeated_only")]
    values = {name: getattr(result, name) for name in names}
    if values.get("psnr_db") == inf:
        values["psnr_db"] = None
    if "evidence" in values:
        values["evidence"] = [entry.to_dict() for entry in values["evidence"]]
    if result.id is not None:
        values["id"] = format_id(result.id)
    return values
