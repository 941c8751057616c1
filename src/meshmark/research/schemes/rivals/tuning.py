"""The strength of a rival's mark, tuned per model to the budget that all schemes have."""

from __future__ import annotations

from collections.abc import Callable

from meshmark.errors import CapacityError
from meshmark.mesh import FloatArray

__all__ = ["strongest"]

ROUNDS = 10
FIRST = 0.25
# The first strength tried, of the highest; a displacement this close below the budget is near enough.
CLOSE = 0.97


def strongest(
    place: Callable[[float], FloatArray],
    rms: Callable[[FloatArray], float],
    budget: float,
    lowest: float,
    highest: float,
) -> tuple[float, FloatArray]:
    """Return the largest strength found whose displacement is within the budget, and its positions (p, 3).

    place: positions for a strength from `lowest` to `highest` (above 0), which displace more for a larger one, at
    first in proportion. Raises `CapacityError` where even the lowest displaces too much.
    """
    low, high, strength = lowest, highest, FIRST * highest
    best: tuple[float, FloatArray] | None = None
    for _ in range(ROUNDS):
        points = place(strength)
        size = rms(points)
        if size <= budget:
            best, low = (strength, points), strength
            if size >= CLOSE * budget or strength >= highest:
                break
        else:
            high = strength
        wanted = min(strength * 0.99 * budget / size, highest) if size > 0.0 else highest
        strength = wanted if low < wanted <= high else (low * high) ** 0.5
    if best is None:
        points = place(lowest)
        if rms(points) > budget:
            raise CapacityError(
                f"the least mark moves the model by more than {100 * budget:g} % of its diagonal"
            )
        best = lowest, points
    return best
