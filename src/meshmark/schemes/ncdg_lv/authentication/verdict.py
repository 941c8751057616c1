"""Authentication: is a model as its maker signed it off, and if not, where was it changed (DESIGN section 7)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshmark.coding.keys import Key
from meshmark.coding.message import format_id
from meshmark.geometry.areas import vertex_areas
from meshmark.mesh import FloatArray, Mesh
from meshmark.report.whereabouts import whereabouts
from meshmark.schemes.ncdg_lv.authentication.examination import DOUBTFUL_LOG10, Examination, examine
from meshmark.schemes.ncdg_lv.authentication.payload import Payload
from meshmark.schemes.ncdg_lv.authentication.region_evidence import connected_parts, region_evidence
from meshmark.schemes.ncdg_lv.authentication.regions import Region, judge_regions
from meshmark.schemes.ncdg_lv.certificate import Certificate
from meshmark.schemes.ncdg_lv.threads import on_one_thread
from meshmark.segmentation.analysis import Segmentation, segment
from meshmark.segmentation.map_segmentation import Regions

__all__ = ["Authentication", "authenticate"]


@dataclass(frozen=True, eq=False)
class Authentication:
    """What the marks of a model say.

    verdict: "authentic", "altered", "not_marked" or "inconclusive"; altered: (n,) which vertices of the file were
    moved, made or laid bare. altered_area_fraction: of the surface, 0 to 1. regions: of the map; region: (n,) the
    one of each vertex. payload: "recovered", "partial" or "none"; content: what was recovered. id: or None.
    log10_false_positive: bound on the chance of these marks (or of the id alone) without the key.
    advice: one sentence for the reader.
    """

    verdict: str
    altered: NDArray[np.bool_]
    altered_area_fraction: float
    regions: tuple[Region, ...]
    region: NDArray[np.int64]
    payload: str
    content: Payload | None
    id: int | None
    log10_false_positive: float
    advice: str
    seconds: float

    @property
    def altered_vertices(self) -> int:
        """Return how many vertices of the file are altered."""
        return int(self.altered.sum())

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields."""
        return {
            "verdict": self.verdict,
            "altered_vertices": self.altered_vertices,
            "altered_area_fraction": self.altered_area_fraction,
            "regions": [region.to_dict() for region in self.regions],
            "payload": self.payload,
            "payload_kind": None if self.content is None else self.content.kind,
            "payload_bytes": 0 if self.content is None else len(self.content.content),
            "id": None if self.id is None else format_id(self.id),
            "log10_false_positive": self.log10_false_positive,
            "advice": self.advice,
            "seconds": self.seconds,
        }


@on_one_thread
def authenticate(mesh: Mesh, key: Key, *, reference: Certificate | Mesh | None = None) -> Authentication:
    """Return whether `mesh` is as it was when it was marked with `key`, and where it is not.

    reference: the certificate or the unmarked original; neither is needed, but a model that is altered throughout
    is still known as the maker's by them. Turning, resizing and moving, another order of vertices or faces, and
    other formats alter nothing. Raises `InputError` where the mesh has no surface.
    """
    start = perf_counter()
    found = examine(mesh, key, reference)
    verdict = _verdict(found, reference)
    map_ = segment(mesh)
    points, faces = found.surface.points, found.surface.faces
    areas = vertex_areas(points, faces)
    altered = found.altered if verdict == "altered" else np.zeros(len(points), bool)
    regions = _of_points(map_, found)
    evidence = region_evidence(faces, regions, found.checks, altered)
    judged = judge_regions(evidence, _centres(points, areas, regions))
    if not found.marked:
        called, chance = ("altered", 1.0) if verdict == "altered" else ("unchecked", 0.0)
        judged = tuple(
            replace(region, verdict=called, probability=chance, checks=0, failed=0, log10_chance=0.0)
            for region in judged
        )
    share = float(areas[altered].sum() / areas.sum())
    return Authentication(
        verdict=verdict,
        altered=altered[found.surface.point_of_vertex],
        altered_area_fraction=share,
        regions=judged,
        region=map_.region,
        payload=_payload(found),
        content=found.payload,
        id=found.id,
        log10_false_positive=found.log10_false_positive,
        advice=_advice(verdict, found, judged, share),
        seconds=perf_counter() - start,
    )


def _verdict(found: Examination, reference: Certificate | Mesh | None) -> str:
    if found.marked:
        return "altered" if found.altered.any() else "authentic"
    if found.id is not None:
        alone = isinstance(reference, Certificate) and reference.more.get("layers") == "ownership"
        return "not_marked" if alone else "altered"
    return "inconclusive" if found.log10_false_positive <= DOUBTFUL_LOG10 else "not_marked"


def _payload(found: Examination) -> str:
    if found.payload is not None:
        return "none" if found.payload.kind == "none" else "recovered"
    return "partial" if found.marked and len(found.checks.index) else "none"


def _of_points(map_: Segmentation, found: Examination) -> Regions:
    first = found.surface.vertex_of_point
    return Regions(map_.region[first], map_.green[first], map_.green_share, map_.blue_share)


def _centres(points: FloatArray, areas: FloatArray, regions: Regions) -> FloatArray:
    """Return (n, 3): the middle of the surface of each region."""
    count = len(regions.green_share)
    weight = np.bincount(regions.region, areas, count)
    moments = [np.bincount(regions.region, areas * points[:, axis], count) for axis in range(3)]
    return np.asarray(np.stack(moments, axis=1) / np.where(weight > 0.0, weight, 1.0)[:, None])


def _advice(verdict: str, found: Examination, regions: tuple[Region, ...], share: float) -> str:
    if verdict == "authentic":
        return "Nothing was changed since it was marked."
    if verdict == "not_marked":
        if found.id is not None:
            return "It carries the owner's id, but was marked without the authentication layer."
        return "No mark of this key was found: another key's, never marked, or changed everywhere."
    if verdict == "inconclusive":
        return "There are too few marks to tell; a model of few points, or a small part of one."
    if not found.marked:
        return (
            "It carries the owner's id, but no mark of authentication holds: it was changed everywhere, or marked "
            "without that layer, which its certificate tells."
        )
    called = [region for region in regions if region.verdict == "altered"]
    where = _where(found)
    return f"{len(called)} of {len(regions)} regions altered: {where}, {100 * share:.2g} % of the surface."


def _where(found: Examination) -> str:
    """Return where the altered parts lie, the largest first, no more than three places."""
    named = list(dict.fromkeys(whereabouts(found.surface.points, _parts(found))))
    return ", ".join(named[:3]) + (" and elsewhere" if len(named) > 3 else "")


def _parts(found: Examination) -> FloatArray:
    """Return the middle (k, 3) of each connected altered part, the largest first."""
    points, faces = found.surface.points, found.surface.faces
    part = connected_parts(faces, found.altered)
    rows = np.flatnonzero(found.altered)
    size = np.bincount(part[rows])
    middle = (
        np.stack([np.bincount(part[rows], points[rows, axis]) for axis in range(3)], axis=1) / size[:, None]
    )
    return np.asarray(middle[np.argsort(-size, kind="stable")])
