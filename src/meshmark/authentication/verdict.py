"""Authentication: is a model as it was signed off, and if not, where was it changed (docs/design.md, section 7)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.as_written import Since
from meshmark.authentication.examination import DOUBTFUL_LOG10, Examination, examine
from meshmark.authentication.payload.payload import Payload
from meshmark.authentication.regions.condition import CONDITIONS
from meshmark.authentication.regions.region import Region
from meshmark.authentication.regions.region_map import RegionMap, region_map
from meshmark.authentication.rounded import Requantised, requantised, rounded_everywhere
from meshmark.authentication.sentences import of_altered, of_causes, of_marks, of_requantised, of_rounded
from meshmark.authentication.shown_otherwise import Cause, causes_of
from meshmark.certificate.certificate import Certificate
from meshmark.coding.chance import band, believable
from meshmark.coding.elapsed import rounded_up
from meshmark.coding.keys import Key
from meshmark.coding.message import format_id, told_id
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.notebook import notebook_table
from meshmark.ownership.extraction import MODES
from meshmark.threads import on_one_thread

__all__ = ["Authentication", "authenticate"]

# Where there is an id but no mark of authentication.
_SINCE = {Since.SAME: "authentic", Since.CHANGED: "altered", Since.UNKNOWN: "inconclusive"}


@dataclass(frozen=True, eq=False, kw_only=True)
class Authentication:
    """What the marks of a model say.

    verdict: "authentic", "surface_intact" (but the file shows something else), "altered", "not_marked" or
    "inconclusive" (also where there is the id alone, and nothing tells whether the model was changed); causes: why
    the file shows something else than what was signed off; requantised: an export rounded the positions as the
    marks bear it, which alters nothing; altered: (n,) which vertices of the file were moved, made or laid bare.
    altered_area_fraction: of the surface, 0 to 1. missing_area_fraction: of the surface that was signed off;
    points_missing: of its points, below 0 where there are more; both None where not known.
    payload: "recovered", "partial" or "none"; content: what was recovered. id: or None.
    log10_false_positive: bound on the chance of these marks (or of the id alone) without the key.
    mode: "blind", "certificate" or "original"; certificate: "own", "foreign" (of another key, model or id) or None.
    advice: sentences for the reader. draw: makes the map, which is made when it is asked for.
    """

    verdict: str
    altered: NDArray[np.bool_]
    altered_area_fraction: float
    missing_area_fraction: float | None
    points_missing: int | None
    payload: str
    content: Payload | None
    id: int | None
    log10_false_positive: float
    mode: str
    certificate: str | None
    advice: str
    seconds: float
    draw: Callable[[], RegionMap] = field(repr=False)
    causes: tuple[Cause, ...] = ()
    requantised: Requantised | None = None

    @cached_property
    def _map(self) -> RegionMap:
        return self.draw()

    @property
    def regions(self) -> tuple[Region, ...]:
        """Return the regions of the map, each with its verdict."""
        return self._map.regions

    @property
    def region(self) -> IntArray:
        """Return (n,): the region of each vertex of the file."""
        return self._map.region

    @property
    def failed_share(self) -> FloatArray:
        """Return (n,): the share of the checks around each vertex that failed, NaN where nothing was checked."""
        return self._map.failed_share

    @property
    def condition(self) -> IntArray:
        """Return (n,): what became of each vertex, an index into `regions.condition.CONDITIONS`."""
        return self._map.condition

    @property
    def altered_vertices(self) -> int:
        """Return how many vertices of the file are altered."""
        return int(self.altered.sum())

    def vertices_that_are(self, condition: str) -> int:
        """Return how many vertices of the file have a condition, one of `regions.condition.CONDITIONS`."""
        return int((self.condition == CONDITIONS.index(condition)).sum())

    def _repr_html_(self) -> str:
        share = self.altered_area_fraction
        altered = f"{self.altered_vertices:,} vertices, {100 * share:.2g} % of the surface"
        return notebook_table(
            self.verdict.replace("_", " ").capitalize(),
            [
                ("What was found", self.advice),
                ("Altered", altered if self.altered_vertices else ""),
                ("Id", "" if self.id is None else format_id(self.id)),
                ("Payload", self.payload),
                ("Read with", self.mode),
            ],
        )

    def to_dict(self, *, diagnose: bool = False) -> dict[str, Any]:
        """Return the JSON fields; the bound in `BANDS` and the time in `SECONDS` unless `diagnose`."""
        bound = self.log10_false_positive
        return {
            "verdict": self.verdict,
            "causes": [cause.to_dict() for cause in self.causes],
            "requantised": self.requantised is not None,
            "requantised_bits": None if self.requantised is None else self.requantised.bits,
            "altered_vertices": self.altered_vertices,
            "moved_vertices": self.vertices_that_are("moved"),
            "cut_off_vertices": self.vertices_that_are("cut_off"),
            "altered_area_fraction": self.altered_area_fraction,
            "missing_area_fraction": self.missing_area_fraction,
            "points_missing": self.points_missing,
            "regions": [region.to_dict() for region in self.regions],
            "payload": self.payload,
            "payload_kind": None if self.content is None else self.content.kind,
            "payload_bytes": 0 if self.content is None else len(self.content.content),
            "id": None if self.id is None else format_id(self.id),
            "log10_false_positive": bound if diagnose else band(bound),
            "mode": self.mode,
            "certificate": self.certificate,
            "advice": self.advice,
            "seconds": self.seconds if diagnose else rounded_up(self.seconds),
        }


@on_one_thread
def authenticate(mesh: Mesh, key: Key, *, reference: Certificate | Mesh | None = None) -> Authentication:
    """Return whether a mesh is as it was when it was marked, and where it is not.

    Turning, resizing and moving, another order of vertices or faces, and other formats alter nothing. What the
    mesh's file shows beside its surface (morph targets, skins, scenes, materials) is looked at, too.

    Parameters
    ----------
    mesh : Mesh
        The suspect.
    key : Key
        That it was marked with.
    reference : Certificate or Mesh, optional
        The certificate or the unmarked original. Neither is needed, but with one of them a model that is altered
        throughout is still recognised.

    Returns
    -------
    Authentication

    Raises
    ------
    InputError
        The mesh has no surface, or the certificate of this key was edited.
    """
    start = perf_counter()
    found = examine(mesh, key, reference)
    export = requantised(mesh, found)
    verdict = "inconclusive" if export is not None and export.simplified else _verdict(found)
    causes = _causes(mesh, key, found, reference)
    if verdict == "authentic" and causes:
        verdict = "surface_intact"
    altered = found.altered if verdict == "altered" else np.zeros(len(found.surface.points), bool)
    share = float(found.surface.point_shares[altered].sum())
    draw = partial(region_map, mesh, found, altered)
    if found.marked and altered.any():
        drawn = draw()
        rounded = rounded_everywhere(mesh, found)
        if rounded is None:
            begin = "" if export is None else of_requantised(export, verdict)
            advice = begin + of_altered(found, drawn.regions, drawn.places(), share)
        else:
            advice = of_rounded(rounded, drawn.places_of(mesh.vertices, rounded.beyond))
        draw = partial(_same, drawn)
    elif export is not None and verdict in ("authentic", "inconclusive"):
        advice = of_requantised(export, verdict)
    else:
        advice = of_marks(verdict, found)
    if causes:
        advice += f" {of_causes(causes, verdict)}"
    if found.remark is not None:
        advice += f" {found.remark}"
    return Authentication(
        verdict=verdict,
        altered=altered[found.surface.point_of_vertex],
        altered_area_fraction=share,
        missing_area_fraction=_missing(found),
        points_missing=found.points_missing,
        payload=_payload(found),
        content=found.payload,
        id=told_id(found.id),
        log10_false_positive=believable(found.log10_false_positive),
        mode=MODES[type(reference)],
        certificate=_certificate(found, reference),
        advice=advice,
        seconds=perf_counter() - start,
        draw=draw,
        causes=causes,
        requantised=export,
    )


def _causes(
    mesh: Mesh, key: Key, found: Examination, reference: Certificate | Mesh | None
) -> tuple[Cause, ...]:
    """Return why the file shows something else; none where there is no mark that could speak of it."""
    if found.id is None:
        return ()
    signed = None if found.payload is None else found.payload.whole.shown
    own = reference if isinstance(reference, Certificate) and found.remark is None else None
    return causes_of(mesh.document, key, signed, own)


def _same(drawn: RegionMap) -> RegionMap:
    return drawn


def _verdict(found: Examination) -> str:
    if found.marked:
        whole = not found.points_missing and found.id is not None
        return "authentic" if whole and not found.altered.any() else "altered"
    if found.id is not None:
        return _SINCE[found.since]
    doubtful = found.present or found.log10_false_positive <= DOUBTFUL_LOG10
    return "inconclusive" if doubtful else "not_marked"


def _certificate(found: Examination, reference: Certificate | Mesh | None) -> str | None:
    if not isinstance(reference, Certificate):
        return None
    return "own" if found.remark is None else "foreign"


def _missing(found: Examination) -> float | None:
    """Return the share that is gone: none where no part is, whatever its area measures."""
    gone = found.checks.new_boundary.any() or (found.points_missing or 0) > 0
    return found.area_missing if gone or not found.marked else 0.0


def _payload(found: Examination) -> str:
    if found.payload is not None:
        return "none" if found.payload.kind == "none" else "recovered"
    return "partial" if found.marked and len(found.checks.carried.index) else "none"
