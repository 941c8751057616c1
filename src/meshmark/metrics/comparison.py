"""All measures of how much one model differs from another, in one result."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass

from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.metrics.displacement import diagonal, max_over_diagonal, rms_over_diagonal
from meshmark.metrics.msdm2 import msdm2
from meshmark.metrics.normal_deviation import normal_deviation_deg
from meshmark.metrics.psnr import paper_psnr_db, psnr_db
from meshmark.metrics.surface_distance import (
    hausdorff_over_diagonal,
    mrms_over_diagonal,
    symmetric_rms_over_diagonal,
)

__all__ = ["Comparison", "compare"]


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """How model B differs from model A, in the measures of `METRICS` of the same names.

    The first two compare the vertices of equal number: None unless the counts are equal. PSNRs are those of the
    vertices, or where the counts differ, of the surfaces. What needs a surface is None where a model has none.
    PSNRs are infinite where nothing moved; JSON has no infinity, so `to_dict` gives None beside an error of 0.
    """

    rms_over_diagonal: float | None
    max_over_diagonal: float | None
    psnr_db: float | None
    paper_psnr_db: float | None
    mrms_over_diagonal: float | None
    symmetric_rms_over_diagonal: float | None
    hausdorff_over_diagonal: float | None
    msdm2: float | None
    normal_deviation_deg: float | None

    def to_dict(self) -> dict[str, float | None]:
        """Return the fields for JSON, with None for what is infinite."""
        return {name: _finite_or_none(value) for name, value in asdict(self).items()}


def compare(a: Mesh, b: Mesh) -> Comparison:
    """Measure how `b` differs from `a`.

    Parameters
    ----------
    a, b : Mesh
        The original and the other model, in the same coordinates.

    Returns
    -------
    Comparison
        One field for each measure; None where it is not defined for these two.

    Raises
    ------
    InputError
        A model has no vertices or no extent.
    """
    for mesh in (a, b):
        diagonal(mesh)
    return Comparison(
        rms_over_diagonal=_or_none(rms_over_diagonal, a, b),
        max_over_diagonal=_or_none(max_over_diagonal, a, b),
        psnr_db=_or_none(psnr_db, a, b),
        paper_psnr_db=_or_none(paper_psnr_db, a, b),
        mrms_over_diagonal=_or_none(mrms_over_diagonal, a, b),
        symmetric_rms_over_diagonal=_or_none(symmetric_rms_over_diagonal, a, b),
        hausdorff_over_diagonal=_or_none(hausdorff_over_diagonal, a, b),
        msdm2=_or_none(msdm2, a, b),
        normal_deviation_deg=_or_none(normal_deviation_deg, a, b),
    )


def _or_none(measure: Callable[[Mesh, Mesh], float], a: Mesh, b: Mesh) -> float | None:
    try:
        return measure(a, b)
    except InputError:  # not defined for these two
        return None


def _finite_or_none(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
