"""What an authentication says in plain words: one or two sentences for the reader."""

from __future__ import annotations

from collections.abc import Sequence

from meshmark.schemes.ncdg_lv.authentication.examination import Examination
from meshmark.schemes.ncdg_lv.authentication.regions import Region

__all__ = ["of_altered", "of_marks"]


def of_marks(verdict: str, found: Examination) -> str:
    """Return the sentence of a model of which no part is called altered by its marks."""
    if verdict == "authentic":
        return "Nothing was changed since it was marked."
    if verdict == "inconclusive":
        return "There are too few marks to tell; a model of few points, or a small part of one."
    if verdict == "altered":
        return "It carries the owner's id, but no mark of authentication holds: it was changed everywhere."
    if found.id is None:
        return "No mark of this key was found: another key's, never marked, or changed everywhere."
    if found.ownership_only:
        return "It carries the owner's id, and was marked without the authentication layer."
    return (
        "It carries the owner's id, but no mark of authentication: it was marked without that layer, or changed a "
        "little everywhere. Its certificate tells which."
    )


def of_altered(
    regions: Sequence[Region], places: Sequence[str], share: float, missing: float | None, torn: bool
) -> str:
    """Return the sentence of a model of which parts were altered.

    places: of the altered regions; share: altered, of the surface; missing: of the surface that was signed off,
    None where it is not known; torn: there are holes that were made.
    """
    called = sum(region.verdict == "altered" for region in regions)
    where = ", ".join(places[:3]) + (" and elsewhere" if len(places) > 3 else "")
    text = f"{called} of {len(regions)} regions altered: {where}, "
    if missing:
        return text + (
            f"where {_percent(missing)} of the signed-off surface is missing; {_percent(share)} of what is left "
            "was altered or lies beside a hole."
        )
    if torn:
        return text + f"{_percent(share)} of the surface, beside holes that were made."
    return text + f"{_percent(share)} of the surface."


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"
