"""The table of search strategies, in the order in which a search goes through them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from meshmark.certificate.certificate import Certificate
from meshmark.late import late_function
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.parameters import DECODE_LOG10
from meshmark.ownership.points.parameters import MOST_UNSMOOTHED
from meshmark.ownership.search.search import Search

__all__ = ["STRATEGIES", "Strategy"]


@dataclass(frozen=True, kw_only=True)
class Strategy:
    """One way in which the mark may be read.

    readings: yields the readings of a search, likeliest first; each has taken a trial of `search.trials`.
    applies: whether a search is to try it at all. cost: processor time of an absent answer, over that of reading a
    surface of 35,000 points as it stands. decode_below: readings whose lock is less likely by chance than 10^this
    are decoded; None: all are. by_reference: it reads in frames that a reference gives.
    """

    name: str
    readings: Callable[[Search], Iterator[Reading]]
    applies: Callable[[Search], bool]
    cost: float
    decode_below: float | None = None
    by_reference: bool = False


def _always(_search: Search) -> bool:
    return True


def _suits_points(search: Search) -> bool:
    return search.suits_points


def _suits_cells_uncertified(search: Search) -> bool:
    """Return whether points are read after cells: there is no certificate to read by first."""
    return not search.suits_points and not isinstance(search.reference, Certificate)


def _suits_cells_certified(search: Search) -> bool:
    """Return whether points are read after what the certificate tells: a reading pays for all before it."""
    return not search.suits_points and isinstance(search.reference, Certificate)


def _may_be_at_points(search: Search) -> bool:
    reference = search.reference
    return reference is not None and (not isinstance(reference, Certificate) or reference.at_points)


def _may_be_in_cells(search: Search) -> bool:
    reference = search.reference
    return reference is not None and not (isinstance(reference, Certificate) and reference.at_points)


def _has_cells(search: Search) -> bool:
    return search.has_cells


def _looks_further(search: Search) -> bool:
    return search.effort != "plain"


def _undoes_damage(search: Search) -> bool:
    """Return whether damage to cells is to be undone; of that to points only smoothing can be."""
    return _looks_further(search) and search.has_cells


def _undoes_stretches(search: Search) -> bool:
    """Return whether a stretch is to be undone: not where cells were left out, unless triangles grew since then."""
    return _undoes_damage(search) and (search.wide or not search.suits_points)


def _undoes_crops(search: Search) -> bool:
    """Return whether a crop is to be undone; of meshes with long triangles none ever told an id (decision 0048)."""
    return _undoes_damage(search) and (search.wide or search.bears_filters)


def _is_coarse(search: Search) -> bool:
    return _undoes_damage(search) and search.is_coarse


def _undoes_smoothing_at_points(search: Search) -> bool:
    """Return whether the points of shapes before a smoothing are to be read: they carry on coarse models only."""
    reference = search.reference
    if isinstance(reference, Certificate) and not reference.at_points:
        return False
    carry = isinstance(reference, Certificate) or search.suits_points
    coarse = search.is_coarse if carry else len(search.surface.points) <= MOST_UNSMOOTHED
    return _looks_further(search) and coarse


_POINTS = Strategy(
    name="points as they stand",
    readings=late_function("meshmark.ownership.search.at_points", "readings_of_points"),
    applies=_suits_points,
    cost=3.0,
    decode_below=DECODE_LOG10,
)

STRATEGIES: tuple[Strategy, ...] = (
    _POINTS,
    Strategy(
        name="as it stands",
        readings=late_function("meshmark.ownership.search.as_it_stands", "readings_as_it_stands"),
        applies=_has_cells,
        cost=1.0,
        decode_below=DECODE_LOG10,
    ),
    replace(_POINTS, name="points after cells", applies=_suits_cells_uncertified),
    Strategy(
        name="copies of one mesh once",
        readings=late_function("meshmark.ownership.search.other_surfaces", "readings_of_copies"),
        applies=_always,
        cost=10.0,
        decode_below=DECODE_LOG10,
    ),
    Strategy(
        name="points registered",
        readings=late_function("meshmark.ownership.search.at_points", "registered_readings_of_points"),
        applies=_may_be_at_points,
        cost=10.0,
        by_reference=True,
    ),
    Strategy(
        name="registered",
        readings=late_function("meshmark.ownership.search.registered", "registered_readings"),
        applies=_may_be_in_cells,
        cost=60.0,
        by_reference=True,
    ),
    replace(_POINTS, name="points after the certificate", applies=_suits_cells_certified),
    Strategy(
        name="mirrored",
        readings=late_function("meshmark.ownership.search.other_surfaces", "mirrored_readings"),
        applies=_looks_further,
        cost=1.0,
        decode_below=DECODE_LOG10,
    ),
    Strategy(
        name="smoothing undone",
        readings=late_function("meshmark.ownership.search.unsmoothed", "unsmoothed_readings"),
        applies=_is_coarse,
        cost=10.0,
    ),
    Strategy(
        name="smoothing undone at points",
        readings=late_function(
            "meshmark.ownership.search.points_unsmoothed", "readings_of_points_unsmoothed"
        ),
        applies=_undoes_smoothing_at_points,
        cost=10.0,
        decode_below=DECODE_LOG10,
    ),
    Strategy(
        name="restored",
        readings=late_function("meshmark.ownership.search.restored", "restored_readings"),
        applies=_undoes_damage,
        cost=10.0,
    ),
    Strategy(
        name="stretched",
        readings=late_function("meshmark.ownership.search.stretched", "stretched_readings"),
        applies=_undoes_stretches,
        cost=5.0,
    ),
    Strategy(
        name="cropped",
        readings=late_function("meshmark.ownership.search.cropped", "cropped_readings"),
        applies=_undoes_crops,
        cost=30.0,
    ),
)
