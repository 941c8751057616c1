"""All measures of how much one model differs from another, in one result."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

from meshmark.mesh import Mesh
from meshmark.metrics.displacement import diagonal, max_over_diagonal, rms_over_diagonal
from meshmark.metrics.psnr import paper_psnr_db, psnr_db

__all__ = ["Comparison", "compare"]


@dataclass(frozen=True)
class Comparison:
    """How model B differs from model A. None where a measure is not defined for the two, or not computed.

    The first two and the PSNRs compare the vertices of equal number: None unless the counts are equal.
    PSNRs are infinite where nothing moved; JSON has no infinity, so `to_dict` gives None beside an
    `rms_over_diagonal` of 0. The last four need surface sampling, which this version does not do.
    """

    rms_over_diagonal: float | None
    max_over_diagonal: float | None
    psnr_db: float | None
    paper_psnr_db: float | None
    mrms_over_diagonal: float | None = None
    hausdorff_over_diagonal: float | None = None
    msdm2: float | None = None
    normal_deviation_deg: float | None = None

    def to_dict(self) -> dict[str, float | None]:
        """Return the fields for JSON, with None for what is infinite."""
        return {name: _finite_or_none(value) for name, value in asdict(self).items()}


def compare(a: Mesh, b: Mesh) -> Comparison:
    """Measure how `b` differs from `a`; raises `InputError` where a model has no vertices or no extent."""
    for mesh in (a, b):
        diagonal(mesh)
    if len(a.vertices) != len(b.vertices):
        return Comparison(None, None, None, None)
    return Comparison(
        rms_over_diagonal=rms_over_diagonal(a, b),
        max_over_diagonal=max_over_diagonal(a, b),
        psnr_db=psnr_db(a, b),
        paper_psnr_db=paper_psnr_db(a, b),
    )


def _finite_or_none(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
