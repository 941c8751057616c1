"""The id that marks of authentication report where the ownership layer reports none."""

from __future__ import annotations

from dataclasses import replace
from math import log10

from meshmark.authentication.checks.checks import check
from meshmark.authentication.examination import MARKED_LOG10
from meshmark.certificate.binding import mismatch
from meshmark.certificate.certificate import Certificate
from meshmark.coding.chance import believable
from meshmark.coding.keys import Key
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.ownership.extraction_result import Evidence, Extraction

__all__ = ["marks_evidence", "with_marks"]

_LAYERS = 2


def marks_evidence(mesh: Mesh, key: Key) -> Evidence | None:
    """Return what the marks of authentication of a mesh report, None where none of this key are surely there.

    Raises `InputError` where the mesh has no surface.
    """
    checks = check(surface_of(mesh), key)
    if checks.nonce is None or checks.log10_chance > MARKED_LOG10:
        return None
    bound = believable(checks.log10_chance)
    return Evidence(layer="authentication", id=checks.nonce, log10_false_positive=bound)


def with_marks(
    found: Extraction, mesh: Mesh, key: Key, reference: Certificate | Mesh | None = None
) -> Extraction:
    """Return what was extracted from a mesh, where that has no id with the one that authentication marks report.

    The bound is then that of the marks, doubled because two layers were looked at. reference: that the extraction
    had; the advice says where it is a certificate of another mark.
    """
    marks = None if found.ids else marks_evidence(mesh, key)
    if marks is None or marks.id is None:
        return found
    remark = mismatch(reference, key, marks.id) if isinstance(reference, Certificate) else None
    beside = "is too damaged to read" if found.evidence else "was not found"
    return replace(
        found,
        presence="present",
        id=marks.id,
        ids=(marks.id,),
        log10_false_positive=min(believable(marks.log10_false_positive + log10(_LAYERS)), 0.0),
        evidence=(*found.evidence, marks),
        advice=f"The id was read from the authentication marks; the ownership mark {beside}. "
        f"`meshmark authenticate` tells which parts are as they were signed off.{f' {remark}' if remark else ''}",
    )
