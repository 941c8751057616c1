"""The verdict per region: the distortion classifier's, in the paper's two passes, top half and bottom half."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from meshmark.authentication.regions.region_classifier import distortion
from meshmark.authentication.regions.region_evidence import RegionEvidence
from meshmark.mesh import FloatArray

__all__ = ["Region", "judge_regions"]


# Number of failed checks, of an altered part that lies mostly elsewhere, that say nothing.
_SPILT = 1


@dataclass(frozen=True, kw_only=True)
class Region:
    """One region of the map.

    id: its number in the map; verdict: "intact", "altered" or "unchecked" (no ring large enough for a mark);
    probability: that it was altered, 0 to 1. log10_chance: bound on that of at least as many failed checks in an
    intact region. checks: points whose ring could carry a mark; failed: those that are altered. centre: (x, y, z)
    of what is altered in it, else of all of it; where: that place in words.
    """

    id: int
    verdict: str
    probability: float
    checks: int
    failed: int
    log10_chance: float
    centre: tuple[float, float, float]
    where: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields."""
        return {**self.__dict__, "centre": list(self.centre)}


def judge_regions(evidence: RegionEvidence, centres: FloatArray) -> tuple[Region, ...]:
    """Return the verdict of each region; centres (n, 3).

    A region is altered where the network says so and some checks failed, or where it holds most of an altered part.
    One failed check that is none of its own may have spilt over from the next region.
    """
    from scipy.special import expit

    checks, failed = evidence.checks.sum(axis=1), evidence.failed.sum(axis=1)
    odds = np.where(failed > _SPILT, distortion(evidence.features), -np.inf)
    called = (odds > 0.0) | evidence.home
    probability = np.where(evidence.home, 1.0, expit(odds))
    chance = np.minimum(evidence.log10_chance.min(axis=1) + np.log10(2.0), 0.0)
    return tuple(
        Region(
            id=i,
            verdict="altered" if called[i] else "intact" if checks[i] else "unchecked",
            probability=float(probability[i]),
            checks=int(checks[i]),
            failed=int(failed[i]),
            log10_chance=float(chance[i]),
            centre=(float(x), float(y), float(z)),
        )
        for i, (x, y, z) in enumerate(centres)
    )
