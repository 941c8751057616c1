"""The table of every measure: its function, unit, range and direction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from meshmark.metrics.bits import ber, correlation, recovered
from meshmark.metrics.detection_rates import detection_rate, present_rate, threshold_for
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

Better = Literal["lower", "higher"]
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
    better: Better
    takes: Takes
    meaning: str

    def __call__(self, *arguments: Any) -> float:
        """Return the measure.

        Parameters
        ----------
        *arguments
            What the function takes, as `takes` and `meaning` say.

        Returns
        -------
        float
            A value within `limits`, in `unit`.

        Raises
        ------
        InputError
            The measure is not defined for what was given.
        """
        return self.function(*arguments)


_INF = float("inf")
_FROM_0, _SHARE, _ALL = (0.0, _INF), (0.0, 1.0), (-_INF, _INF)


class _Kind(NamedTuple):
    """What metrics have in common: unit, range, the good end, and what they take."""

    unit: str
    limits: tuple[float, float]
    better: Better
    takes: Takes


_DISTANCE = _Kind("of the diagonal", _FROM_0, "lower", "meshes")
_PSNR = _Kind("dB", _ALL, "higher", "meshes")
_VISIBLE = _Kind("", _SHARE, "lower", "meshes")
_ANGLE = _Kind("degrees", (0.0, 180.0), "lower", "meshes")
_BIT_ERRORS = _Kind("of the bits", _SHARE, "lower", "bits")
_CORRELATION = _Kind("", (-1.0, 1.0), "higher", "bits")
_PAYLOAD = _Kind("", _SHARE, "higher", "bits")
_MAP = _Kind("of the vertices", _SHARE, "higher", "vertex maps")
_IMAGE = _Kind("dB", _ALL, "higher", "images")
_HITS = _Kind("of the trials", _SHARE, "higher", "scores")
_ALARMS = _Kind("of the trials", _SHARE, "lower", "scores")
_THRESHOLD = _Kind("of the score", _ALL, "lower", "scores")
_SPEED = _Kind("1/s", _FROM_0, "higher", "run")
_MEMORY = _Kind("MiB", _FROM_0, "lower", "run")


def _row(function: Callable[..., float], kind: _Kind, meaning: str) -> Metric:
    return Metric(function=function, meaning=meaning, **kind._asdict())


METRICS: dict[str, Metric] = {
    "rms_over_diagonal": _row(
        rms_over_diagonal, _DISTANCE, "root mean square displacement of vertices; needs equal counts"
    ),
    "max_over_diagonal": _row(
        max_over_diagonal, _DISTANCE, "largest vertex displacement; needs equal counts"
    ),
    "mrms_over_diagonal": _row(
        mrms_over_diagonal, _DISTANCE, "RMS distance between the surfaces, the larger of both directions"
    ),
    "symmetric_rms_over_diagonal": _row(
        symmetric_rms_over_diagonal,
        _DISTANCE,
        "RMS distance between the surfaces, the mean of both directions",
    ),
    "hausdorff_over_diagonal": _row(
        hausdorff_over_diagonal,
        _DISTANCE,
        "largest distance between the surfaces, the larger of both directions",
    ),
    "psnr_db": _row(psnr_db, _PSNR, "20 log10(diagonal / RMS distance)"),
    "paper_psnr_db": _row(paper_psnr_db, _PSNR, "eq. 17 with the longest side scaled to 1"),
    "msdm2": _row(msdm2, _VISIBLE, "visible difference of the second model to one who knows the first"),
    "msdm2_symmetric": _row(msdm2_symmetric, _VISIBLE, "visible difference, the mean of both directions"),
    "normal_deviation_deg": _row(
        normal_deviation_deg, _ANGLE, "mean angle between normals at matched points"
    ),
    "recovery_rms_over_diagonal": _row(
        recovery_rms_over_diagonal,
        _DISTANCE,
        "RMS distance of a recovered surface from the original, the mean of both directions",
    ),
    "ber": _row(ber, _BIT_ERRORS, "bit error rate; 0.5 is chance"),
    "correlation": _row(correlation, _CORRELATION, "Pearson correlation of payloads; 0 is chance"),
    "recovered": _row(recovered, _PAYLOAD, "1 where every bit of the payload is right, else 0"),
    "precision": _row(precision, _MAP, "of those called altered, the share that is"),
    "recall": _row(recall, _MAP, "of those altered, the share that was found"),
    "iou": _row(iou, _MAP, "rightly called altered, over altered or called so"),
    "image_psnr_db": _row(image_psnr_db, _IMAGE, "20 log10(peak / RMS difference) of an extracted image"),
    "true_positive_rate": _row(
        present_rate, _HITS, "(scores of marked models, threshold): share called present"
    ),
    "false_positive_rate": _row(
        present_rate, _ALARMS, "(scores of unmarked models, threshold): share called present"
    ),
    "threshold": _row(
        threshold_for,
        _THRESHOLD,
        "(scores of unmarked models, false-positive rate): the lowest threshold that keeps the rate",
    ),
    "detection_rate": _row(
        detection_rate, _HITS, "(marked, unmarked, false-positive rate): true-positive rate at that threshold"
    ),
    "vertices_per_second": _row(vertices_per_second, _SPEED, "(vertices, seconds): speed by wall clock"),
    "peak_memory_mb": _row(peak_memory_mb, _MEMORY, "(): most memory this process has held"),
}
