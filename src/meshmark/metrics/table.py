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


@dataclass(frozen=True)
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
    "rms_over_diagonal": Metric(rms_over_diagonal, "of the diagonal", _FROM_0, "lower", "meshes",
        "root mean square displacement of vertices; needs equal counts"),
    "max_over_diagonal": Metric(max_over_diagonal, "of the diagonal", _FROM_0, "lower", "meshes",
        "largest vertex displacement; needs equal counts"),
    "mrms_over_diagonal": Metric(mrms_over_diagonal, "of the diagonal", _FROM_0, "lower", "meshes",
        "RMS distance between the surfaces, the larger of both directions"),
    "symmetric_rms_over_diagonal": Metric(symmetric_rms_over_diagonal, "of the diagonal", _FROM_0, "lower",
        "meshes", "RMS distance between the surfaces, the mean of both directions"),
    "hausdorff_over_diagonal": Metric(hausdorff_over_diagonal, "of the diagonal", _FROM_0, "lower", "meshes",
        "largest distance between the surfaces, the larger of both directions"),
    "psnr_db": Metric(psnr_db, "dB", _ALL, "higher", "meshes",
        "20 log10(diagonal / RMS distance)"),
    "paper_psnr_db": Metric(paper_psnr_db, "dB", _ALL, "higher", "meshes",
        "eq. 17 with the longest side scaled to 1"),
    "msdm2": Metric(msdm2, "", _SHARE, "lower", "meshes",
        "visible difference of the second model to one who knows the first"),
    "msdm2_symmetric": Metric(msdm2_symmetric, "", _SHARE, "lower", "meshes",
        "visible difference, the mean of both directions"),
    "normal_deviation_deg": Metric(normal_deviation_deg, "degrees", (0.0, 180.0), "lower", "meshes",
        "mean angle between normals at matched points"),
    "recovery_rms_over_diagonal": Metric(recovery_rms_over_diagonal, "of the diagonal", _FROM_0, "lower", "meshes",
        "RMS distance of a recovered surface from the original, the mean of both directions"),
    "ber": Metric(ber, "of the bits", _SHARE, "lower", "bits",
        "bit error rate; 0.5 is chance"),
    "correlation": Metric(correlation, "", (-1.0, 1.0), "higher", "bits",
        "Pearson correlation of payloads; 0 is chance"),
    "recovered": Metric(recovered, "", _SHARE, "higher", "bits",
        "1 where every bit of the payload is right, else 0"),
    "precision": Metric(precision, "of the vertices", _SHARE, "higher", "vertex maps",
        "of those called altered, the share that is"),
    "recall": Metric(recall, "of the vertices", _SHARE, "higher", "vertex maps",
        "of those altered, the share that was found"),
    "iou": Metric(iou, "of the vertices", _SHARE, "higher", "vertex maps",
        "rightly called altered, over altered or called so"),
    "image_psnr_db": Metric(image_psnr_db, "dB", _ALL, "higher", "images",
        "20 log10(peak / RMS difference) of an extracted image"),
    "true_positive_rate": Metric(present_rate, "of the trials", _SHARE, "higher", "scores",
        "(scores of marked models, threshold): share called present"),
    "false_positive_rate": Metric(present_rate, "of the trials", _SHARE, "lower", "scores",
        "(scores of unmarked models, threshold): share called present"),
    "threshold": Metric(threshold_for, "of the score", _ALL, "lower", "scores",
        "(scores of unmarked models, false-positive rate): the lowest threshold that keeps the rate"),
    "detection_rate": Metric(detection_rate, "of the trials", _SHARE, "higher", "scores",
        "(marked, unmarked, false-positive rate): true-positive rate at that threshold"),
    "vertices_per_second": Metric(vertices_per_second, "1/s", _FROM_0, "higher", "run",
        "(vertices, seconds): speed by wall clock"),
    "peak_memory_mb": Metric(peak_memory_mb, "MiB", _FROM_0, "lower", "run",
        "(): most memory this process has held"),
}
# fmt: on
