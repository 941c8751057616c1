"""The shapes that a coarse suspect may have had before it was smoothed.

On a coarse mesh the mark lives in frequencies that no low-pass may touch. But smoothing by neighbours' means
multiplies each frequency x of the mesh by (1 - s x)^n, s its strength and n its passes, and that has an inverse:
nothing is missing then but what rounding lost. Half a pass too many spoils it, so each number of passes that people
are likely to choose is tried (docs/decisions/0013).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Final

import numpy as np

from meshmark.geometry.scale_space import spectral_filters
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray

__all__ = ["LARGEST_AREA", "SHAPES", "shapes_before"]

# What may have been done: shares of the way to the neighbours' mean, one after another, and how many times that.
SMOOTHINGS: Final[dict[tuple[float, ...], tuple[int, ...]]] = {
    (0.1,): (1, 2, 3, 5, 10, 15, 20, 30, 50),
    (0.5,): (1, 2, 3, 4, 5, 6),
    (0.5, -0.53): (1, 2, 3, 5, 10),  # Taubin's, doi:10.1145/218380.218473
}
# A frequency of which less is left than this is held back: a tenth of what is left of the frequency 1.95 (of at
# most 2), but between these shares; nothing is where more is left of all frequencies.
FAINTEST, FAINT, HIGH = 1e-5, 1e-2, 1.95
TERMS: Final = 300

SHAPES: Final = sum(map(len, SMOOTHINGS.values()))
"""Number of shapes at most."""
LARGEST_AREA: Final = 160.0
"""Where more is undone than was done the surface gets rough: its area over the squared scale of its frame goes up
to thousands. What has more than this, and than twice what the suspect has, is left out unless the search is wide,
and then what has ten times as much: of 659 training models none has more than 113 (decision 0048)."""


def shapes_before(surface: Surface) -> Iterator[FloatArray]:
    """Yield the shapes (p, 3) that the suspect may have had before."""
    centre = surface.points.mean(axis=0)
    filters = [_inverse(shares, n) for shares, passes in SMOOTHINGS.items() for n in passes]
    for part in spectral_filters(surface.walk, surface.points - centre, filters, TERMS):
        yield centre + part


def _inverse(shares: Sequence[float], passes: int) -> Callable[[FloatArray], FloatArray]:
    """Return the inverse of `passes` passes; where they leave next to nothing it is held back."""

    def left(x: FloatArray) -> FloatArray:
        return np.asarray(np.prod([(1.0 - share * x) ** passes for share in shares], axis=0))

    high, highest = left(np.array([HIGH, 2.0]))
    least = 0.0 if highest > FAINT else float(np.clip(0.1 * high, FAINTEST, FAINT))
    return lambda x: left(x) / (left(x) ** 2 + least**2)
