"""What an authentication says in plain words: one or two sentences for the reader."""

from __future__ import annotations

from collections.abc import Sequence

from meshmark.authentication.as_written import WRONG_LOG10
from meshmark.authentication.examination import Examination
from meshmark.authentication.regions.region import Region
from meshmark.authentication.rounded import Requantised, Rounded
from meshmark.authentication.shown_otherwise import Cause
from meshmark.coding.message import PRESENCE

__all__ = ["of_altered", "of_causes", "of_marks", "of_number", "of_requantised", "of_rounded"]


def of_marks(verdict: str, found: Examination) -> str:
    """Return the sentence of a model of which no part is called altered by its marks."""
    if verdict == "surface_intact":
        return "The surface is as it was when it was marked, but the file shows something else."
    if verdict == "authentic" and not found.marked:
        return (
            "Nothing was changed since it was marked: its positions and faces are those that its certificate was "
            "made for."
        )
    if verdict == "authentic":
        return "Nothing was changed since it was marked."
    if found.id is not None and not found.marked:
        return _of_id(verdict, found)
    if found.present and not found.marked:
        return _of_no_id(found)
    if verdict == "inconclusive":
        return "There are too few marks to tell; a model of few points, or a small part of one."
    if verdict == "altered" and found.id is None:
        return (
            "Its marks of authentication hold, but the id beneath them is not read any more: points without marks "
            "were moved, or parts are gone."
        )
    if verdict == "altered" and found.points_missing:
        return of_number(found.points_missing, found.area_missing)
    return "No mark of this key was found: another key's, never marked, or changed everywhere."


def _of_no_id(found: Examination) -> str:
    """Return the sentence of a model with the owner's mark, but no single id and no mark of authentication."""
    if found.ids:
        return (
            f"It carries the ids of {len(found.ids)} copies, which were put together, and no mark of "
            "authentication: where it differs from either cannot be told."
        )
    return (
        "It carries the owner's mark, but its id cannot be read, and no mark of authentication holds: it was "
        "changed everywhere, or put together from several copies."
    )


def _of_id(verdict: str, found: Examination) -> str:
    """Return the sentence of a model with the id, but without a mark of authentication."""
    carries = "It carries the owner's mark" if found.id == PRESENCE else "It carries the owner's id"
    if verdict == "altered" and found.ownership_only:
        return (
            f"{carries}, but less clearly than when it was marked: the surface was changed by more "
            f"than rounding, an error below 10^{WRONG_LOG10:.0f}. It was marked without the authentication layer, "
            "so where it was changed cannot be told."
        )
    if verdict == "altered":
        return f"{carries}, but no mark of authentication holds: it was changed everywhere."
    if found.ownership_only:
        return (
            f"{carries}, and was marked without the authentication layer: no change shows, but "
            "whether there was none cannot be told."
        )
    if found.rounded is not None:
        return (
            f"{carries}, but was rounded to {found.rounded} everywhere, and no mark of "
            "authentication bears that: whether more was changed cannot be told."
        )
    return (
        f"{carries}, but no mark of authentication: it was marked without that layer, or changed "
        "everywhere; whether it was changed cannot be told. Its certificate may tell."
    )


def of_altered(found: Examination, regions: Sequence[Region], places: Sequence[str], share: float) -> str:
    """Return the sentence of a model of which parts were altered.

    places: of the altered regions; share: altered, of the surface.
    """
    gone, new_boundary = found.points_missing or 0, bool(found.checks.new_boundary.any())
    missing = found.area_missing if new_boundary or gone > 0 else None
    called = sum(region.verdict == "altered" for region in regions)
    where = ", ".join(places[:3]) + (" and elsewhere" if len(places) > 3 else "")
    text = f"{called} of {len(regions)} regions altered: {where}, "
    if missing:
        return text + (
            f"where {_percent(missing)} of the signed-off surface is missing; {_percent(share)} of what is left "
            "was altered or lies beside a hole."
        )
    if new_boundary:
        points = f"; {gone:,} points are missing" if gone > 0 else ""
        return text + f"{_percent(share)} of the surface, beside holes that were made{points}."
    if gone < 0:
        return text + f"{_percent(share)} of the surface; {-gone:,} points were added."
    return text + f"{_percent(share)} of the surface."


def of_rounded(rounded: Rounded, beyond: Sequence[str]) -> str:
    """Return the sentence of a model that was rounded everywhere, more coarsely than its marks bear.

    beyond: where more was changed than rounding explains.
    """
    text = (
        f"Rounded to {rounded.called} everywhere, more coarsely than the tolerance it was marked with bears"
    )
    if beyond:
        where = ", ".join(beyond[:3]) + (" and elsewhere" if len(beyond) > 3 else "")
        return f"{text}. Changed beyond that: {where}."
    if not rounded.clear:
        return f"{text}: too few marks are left to tell whether more was changed."
    return f"{text}; no larger part was changed beyond that."


def of_requantised(export: Requantised, verdict: str) -> str:
    """Return the sentence, or its beginning, of a model that an export rounded as its marks bear."""
    bits = "" if export.bits is None else f" to {export.bits} bits"
    if export.simplified:
        return (
            f"Requantised{bits} and simplified: points are fewer here and there; whether more was changed in these "
            "places cannot be told, elsewhere nothing was."
        )
    return (
        f"Requantised{bits}, otherwise as signed off." if verdict == "authentic" else f"Requantised{bits}; "
    )


def of_causes(causes: Sequence[Cause], verdict: str) -> str:
    """Return the sentence that names why a file shows something else than what was signed off."""
    clauses = "; ".join(cause.sentence for cause in causes)
    if verdict == "surface_intact":
        return f"{clauses[0].upper()}{clauses[1:]}."
    return f"Besides, the file shows more than its surface: {clauses}."


def of_number(missing: int, area: float | None) -> str:
    """Return the sentence of a model whose marks all hold, though it has another number of points."""
    if missing < 0:
        return f"{-missing:,} points were added since it was marked; all that was there is as it was."
    share = f", {_percent(area)} of the signed-off surface" if area else ""
    return f"Whole parts are missing: {missing:,} points{share}; what is left is as it was."


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"
