"""How much one model differs from another: one function per measure, and the table of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from meshmark.mesh import Mesh
from meshmark.metrics.comparison import Comparison, compare
from meshmark.metrics.displacement import max_over_diagonal, rms_over_diagonal
from meshmark.metrics.psnr import paper_psnr_db, psnr_db

__all__ = ["METRICS", "Comparison", "Metric", "compare"]


@dataclass(frozen=True)
class Metric:
    """One measure of how model `b` differs from model `a`; call it as `metric(a, b)`.

    limits: smallest and largest value; `better` says which end two equal models are at.
    """

    function: Callable[[Mesh, Mesh], float]
    unit: str
    limits: tuple[float, float]
    better: Literal["lower", "higher"]
    meaning: str

    def __call__(self, a: Mesh, b: Mesh) -> float:
        """Return the measure; raises `InputError` where it is not defined for the two models."""
        return self.function(a, b)


_INF = float("inf")

METRICS: dict[str, Metric] = {
    "rms_over_diagonal": Metric(
        rms_over_diagonal,
        "of the diagonal",
        (0.0, _INF),
        "lower",
        "root mean square displacement of vertices",
    ),
    "max_over_diagonal": Metric(
        max_over_diagonal, "of the diagonal", (0.0, _INF), "lower", "largest vertex displacement"
    ),
    "psnr_db": Metric(psnr_db, "dB", (-_INF, _INF), "higher", "20 log10(diagonal / RMS displacement)"),
    "paper_psnr_db": Metric(
        paper_psnr_db,
        "dB",
        (-_INF, _INF),
        "higher",
        "eq. 17 with the longest side scaled to 1",
    ),
}
