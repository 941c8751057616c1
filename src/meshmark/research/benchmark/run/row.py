"""One measured case of a benchmark: what was done, how it ended, and the figures."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["STATUSES", "TRIALS", "Case", "Row"]

# What the reader is given, and what the truth is.
TRIALS = {
    "marked": "the marked model, attacked; the mark should be found",
    "wrong key": "the marked model, attacked, read with another key; nothing should be found",
    "unmarked": "the original, attacked; nothing should be found",
    "forged": "the original with a mark copied from another marked model; nothing should be found",
}
STATUSES = ("ok", "refused", "failed", "timeout", "killed")


@dataclass(frozen=True, order=True)
class Case:
    """What is done: a scheme marks a model, an attack follows, the scheme reads.

    model:   path of the model below the data folder, with forward slashes.
    budget:  strength of embedding ("subtle", "standard", "strong").
    attack:  a chain such as "noise:0.005" or "crop:0.1+noise:0.003+similarity:1"; "none" for an untouched mark.
    trial:   one of `TRIALS`.
    seed:    of the whole run. repeat: 0, 1, ... where the same is done with other random numbers.
    """

    suite: str
    scheme: str
    model: str
    budget: str
    attack: str
    trial: str
    seed: int
    repeat: int = 0


@dataclass(frozen=True, kw_only=True)
class Row:
    """A case and its outcome; figures are None where they do not apply or were not reached.

    status:  "ok", "refused" (the scheme says the model cannot carry the mark), "failed", "timeout" or "killed".
    note:    one sentence where the status is not "ok".
    points:  different points of the model; size_class: as in the data's README; split: "train", "test" or "".
    Distortion of the marked model against the original: rms_over_diagonal ... normal_deviation_deg.
    attacked_psnr_db: of the attacked marked model against the original, over the vertices that are left of it, as
             they stand (nothing is turned back); None where the attack makes a new surface.
    ber, correlation: of the payload (after collusion: of the colluder's that is nearest to what was read; of a
             forged mark: the donor's); raw_ber: of the carriers before error correction, where the scheme tells.
    present: the scheme says a mark is there; decoded: and that its error correction has the payload right;
    recovered: present and every bit right.
    log10_false_positive: the scheme's bound.
    Seconds are wall-clock; file_seconds: reading the model's file and writing it again, for comparison;
    vertices_per_second: of the attacked model, in extraction; peak_mb: the worker's peak memory in this case.
    """

    case: Case
    status: str
    note: str = ""
    points: int | None = None
    size_class: str | None = None
    split: str = ""
    rms_over_diagonal: float | None = None
    max_over_diagonal: float | None = None
    mrms_over_diagonal: float | None = None
    symmetric_rms_over_diagonal: float | None = None
    hausdorff_over_diagonal: float | None = None
    psnr_db: float | None = None
    paper_psnr_db: float | None = None
    msdm2: float | None = None
    normal_deviation_deg: float | None = None
    attacked_psnr_db: float | None = None
    ber: float | None = None
    raw_ber: float | None = None
    correlation: float | None = None
    present: bool | None = None
    decoded: bool | None = None
    recovered: bool | None = None
    log10_false_positive: float | None = None
    file_seconds: float | None = None
    embed_seconds: float | None = None
    attack_seconds: float | None = None
    extract_seconds: float | None = None
    vertices_per_second: float | None = None
    peak_mb: float | None = None
