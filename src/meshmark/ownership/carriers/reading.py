"""What a search decodes: carriers read under one hypothesis, with how well they lock and what that is worth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from meshmark.coding.keyed_code import LENGTH
from meshmark.mesh import FloatArray
from meshmark.ownership.carriers.lattice import CellKeys
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.quantisation import log_likelihood_ratio, log_likelihood_ratio_of_points

__all__ = ["Reading"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Reading:
    """n carriers, read with one quantisation step.

    label, spacing: of the lattice, spacing in canonical units; step: of the quantisation, in spacings. keys: what
    the key says of the carriers. phase: (n,) radians. score: `lock_score`; log10_chance: of the score alone, one
    hypothesis; hypotheses: what the chance is to be multiplied by (`TrialCounter`). mirrored: read in the suspect's
    mirror image. at_points: the carriers are coordinates of points.
    """

    label: Label
    spacing: float
    step: float
    keys: CellKeys
    phase: FloatArray
    score: float
    log10_chance: float
    hypotheses: float
    mirrored: bool = False
    at_points: bool = False

    def ratios(self) -> FloatArray:
        """Return the log-likelihood ratio (n,) of the bit of each carrier, 0 where it has none."""
        ratio = log_likelihood_ratio_of_points if self.at_points else log_likelihood_ratio
        return np.where(self.keys.pilot, 0.0, ratio(self.phase))

    def observed(self) -> FloatArray:
        """Return the log-likelihood ratio of each code bit, 0 where no carrier has it."""
        return np.bincount(self.keys.code_index, self.ratios(), LENGTH).astype(np.float64)

    def doubled(self) -> FloatArray:
        """Return the cosine of the doubled phase of each code bit, 0 where no carrier has it.

        Of an average of two copies it is positive where the two have the same bit, else negative.
        """
        cosine = np.where(self.keys.pilot, 0.0, np.cos(2.0 * self.phase))
        return np.bincount(self.keys.code_index, cosine, LENGTH).astype(np.float64)
