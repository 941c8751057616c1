"""The table of every measure: its function, unit, range and direction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from meshmark.metrics.bits import ber, correlation, recovered
from meshmark.metrics.detection import detection_rate, present_rate, threshold_for
from meshmark.metrics.displacement import max_over_diagonal, rms_over_diagonal
from meshmark.metrics.image import image_psnr_db
from meshmark.metrics.msdm2 import msdm2, msdm2_symmetric
from meshmark.metrics.normal_deviation import normal_deviation_deg
from meshmark.metrics.psnr import paper_psnr_db, psnr_db
from meshmark.metrics.recovery import recovery_rms_over_diagonal
from meshmark.metrics.surface_distance import (
    hausdorff_over_diagonal,
    mrms_over_diagonal,
    symmetric_rms_over_diagonal,
)
from meshmark.metrics.tamper import iou, precision, recall
from meshmark.metrics.throughput import peak_memory_mb, vertices_per_second

__all__ = ["METRICS", "Metric"]

Takes = Literal["meshes", "bits", "vertex maps", "images", "scores", "run"]


@dataclass(frozen=True, kw_only=True)
class Metric:
    """One measure; call it as `metric(...)` with what its function takes, most often (original, other).

    limits: smallest and largest value; `better` says which end is the good one, where two equal models, payloads,
    maps or images are. takes: what kind of thing is measured.
    """

    function: Callable[..., float]
    unit: str
    limits: tuple[float, float]
    better: Literal["lower", "higher"]
    takes: Takes
    meaning: str

    def __call__(self, *arguments: Any) -> float:
        """Return the measure; raises `InputError` where it is not defined for what was given."""
        return self.function(*arguments)


_INF = float("inf")
_FROM_0, _SHARE, _ALL = (0.0, _INF), (0.0, 1.0), (-_INF, _INF)

# fmt: off
METRICS: dict[str, Metric] = {
    # name: function, unit, range, better, takes, meaning
    "rms_over_diagonal": Metric(function=rms_over_diagonal, unit="of the diagonal", limits=_FROM_0, better="lower", takes="meshes",
        meaning="root mean square displacement of vertices; needs equal counts"),
    "max_over_diagonal": Metric(function=max_over_diagonal, unit="of the diagonal", limits=_FROM_0, better="lower", takes="meshes",
        meaning="largest vertex displacement; needs equal counts"),
    "mrms_over_diagonal": Metric(function=mrms_over_diagonal, unit="of the diagonal", limits=_FROM_0, better="lower", takes="meshes",
        meaning="RMS distance between the surfaces, the larger of both directions"),
    "symmetric_rms_over_diagonal": Metric(function=symmetric_rms_over_diagonal, unit="of the diagonal", limits=_FROM_0, better="lower",
        takes="meshes", meaning="RMS distance between the surfaces, the mean of both directions"),
    "hausdorff_over_diagonal": Metric(function=hausdorff_over_diagonal, unit="of the diagonal", limits=_FROM_0, better="lower", takes="meshes",
        meaning="largest distance between the surfaces, the larger of both directions"),
    "psnr_db": Metric(function=psnr_db, unit="dB", limits=_ALL, better="higher", takes="meshes",
        meaning="20 log10(diagonal / RMS distance)"),
    "paper_psnr_db": Metric(function=paper_psnr_db, unit="dB", limits=_ALL, better="higher", takes="meshes",
        meaning="eq. 17 with the longest side scaled to 1"),
    "msdm2": Metric(function=msdm2, unit="", limits=_SHARE, better="lower", takes="meshes",
        meaning="visible difference of the second model to one who knows the first"),
    "msdm2_symmetric": Metric(function=msdm2_symmetric, unit="", limits=_SHARE, better="lower", takes="meshes",
        meaning="visible difference, the mean of both directions"),
    "normal_deviation_deg": Metric(function=normal_deviation_deg, unit="degrees", limits=(0.0, 180.0), better="lower", takes="meshes",
        meaning="mean angle between normals at matched points"),
    "recovery_rms_over_diagonal": Metric(function=recovery_rms_over_diagonal, unit="of the diagonal", limits=_FROM_0, better="lower", takes="meshes",
        meaning="RMS distance of a recovered surface from the original, the mean of both directions"),
    "ber": Metric(function=ber, unit="of the bits", limits=_SHARE, better="lower", takes="bits",
        meaning="bit error rate; 0.5 is chance"),
    "correlation": Metric(function=correlation, unit="", limits=(-1.0, 1.0), better="higher", takes="bits",
        meaning="Pearson correlation of payloads; 0 is chance"),
    "recovered": Metric(function=recovered, unit="", limits=_SHARE, better="higher", takes="bits",
        meaning="1 where every bit of the payload is right, else 0"),
    "precision": Metric(function=precision, unit="of the vertices", limits=_SHARE, better="higher", takes="vertex maps",
        meaning="of those called altered, the share that is"),
    "recall": Metric(function=recall, unit="of the vertices", limits=_SHARE, better="higher", takes="vertex maps",
        meaning="of those altered, the share that was found"),
    "iou": Metric(function=iou, unit="of the vertices", limits=_SHARE, better="higher", takes="vertex maps",
        meaning="rightly called altered, over altered or called so"),
    "image_psnr_db": Metric(function=image_psnr_db, unit="dB", limits=_ALL, better="higher", takes="images",
        meaning="20 log10(peak / RMS difference) of an extracted image"),
    "true_positive_rate": Metric(function=present_rate, unit="of the trials", limits=_SHARE, better="higher", takes="scores",
        meaning="(scores of marked models, threshold): share called present"),
    "false_positive_rate": Metric(function=present_rate, unit="of the trials", limits=_SHARE, better="lower", takes="scores",
        meaning="(scores of unmarked models, threshold): share called present"),
    "threshold": Metric(function=threshold_for, unit="of the score", limits=_ALL, better="lower", takes="scores",
        meaning="(scores of unmarked models, false-positive rate): the lowest threshold that keeps the rate"),
    "detection_rate": Metric(function=detection_rate, unit="of the trials", limits=_SHARE, better="higher", takes="scores",
        meaning="(marked, unmarked, false-positive rate): true-positive rate at that threshold"),
    "vertices_per_second": Metric(function=vertices_per_second, unit="1/s", limits=_FROM_0, better="higher", takes="run",
        meaning="(vertices, seconds): speed by wall clock"),
    "peak_memory_mb": Metric(function=peak_memory_mb, unit="MiB", limits=_FROM_0, better="lower", takes="run",
        meaning="(): most memory this process has held"),
}
# fmt: on
