"""The modules of NCDG-LV and what the paper's ablation puts in their places.

What each serves in this design, and so what it is measured on:

saliency      seeds of the map of regions; nothing in the id, the marks or the per-point map depends on it
segmentation  the map of regions: what the distortion classifier judges and a report names
embedding     the carriers of the id: barycentres of cells, or least significant bits (scheme "lsb")
extraction    soft bits of the id, and verdicts on regions: Levenberg-Marquardt networks, or the plain rules
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from meshmark.errors import InputError
from meshmark.geometry.surface import Surface
from meshmark.mesh import FloatArray, IntArray, Mesh
from meshmark.research.ablation.extraction_rules import EXTRACTIONS
from meshmark.research.schemes.clusters import fuzzy_c_means_regions, k_means_regions
from meshmark.research.schemes.rivals.adf import Adf
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.laplace_beltrami import LaplaceBeltrami
from meshmark.research.schemes.rivals.regional import Regional
from meshmark.saliency.nc_dgg import saliency
from meshmark.saliency.salient_points import salient_points
from meshmark.segmentation.map_segmentation import Regions, choose_seeds, default_regions, map_regions

__all__ = ["EMBEDDINGS", "FULL", "PAPER", "SALIENCY", "SEGMENTATION", "Modules", "region_map"]


def _nc_dgg(points: FloatArray, faces: IntArray, _: np.random.Generator) -> tuple[FloatArray, IntArray]:
    found = saliency(points, faces)
    return found.beta, salient_points(found.beta, points, found.walk, rings=found.rings)


def _random(points: FloatArray, _: IntArray, rng: np.random.Generator) -> tuple[FloatArray, IntArray]:
    count = min(len(points), default_regions(len(points)))
    return np.ones(len(points)), rng.choice(len(points), count, replace=False)


def _voted(points: FloatArray, faces: IntArray, rival: Regional) -> tuple[FloatArray, IntArray]:
    strength = np.zeros(len(points))
    strength[np.unique(faces)] = rival.votes(Host(Mesh(points, faces)))
    strength /= strength.max() or 1.0
    order = np.argsort(-strength, kind="stable")
    return strength, order[: int((strength > 0.0).sum())]


def _laplace_beltrami(
    points: FloatArray, faces: IntArray, _: np.random.Generator
) -> tuple[FloatArray, IntArray]:
    return _voted(points, faces, LaplaceBeltrami())


def _adf(points: FloatArray, faces: IntArray, _: np.random.Generator) -> tuple[FloatArray, IntArray]:
    return _voted(points, faces, Adf())


# Strength (p,) of each point and the salient ones (k,), of points (p, 3) and faces (m, 3).
SALIENCY: dict[str, Callable[[FloatArray, IntArray, np.random.Generator], tuple[FloatArray, IntArray]]] = {
    "nc_dgg": _nc_dgg,
    "random": _random,
    "laplace_beltrami": _laplace_beltrami,
    "adf": _adf,
}
# Regions of points (p, 3) and faces (m, 3) around seeds (n,).
SEGMENTATION: dict[str, Callable[[FloatArray, IntArray, IntArray], Regions]] = {
    "map": map_regions,
    "k_means": k_means_regions,
    "fuzzy_c_means": fuzzy_c_means_regions,
}
# The scheme whose rows show an embedding.
EMBEDDINGS = {"barycentre": "ncdg_lv", "lsb": "lsb"}


@dataclass(frozen=True, kw_only=True)
class Modules:
    """One choice for each module, by the names of the tables above."""

    saliency: str = "nc_dgg"
    segmentation: str = "map"
    embedding: str = "barycentre"
    extraction: str = "network"

    def __post_init__(self) -> None:
        known: tuple[Collection[str], ...] = (SALIENCY, SEGMENTATION, EMBEDDINGS, EXTRACTIONS)
        for name, choices in zip(("saliency", "segmentation", "embedding", "extraction"), known, strict=True):
            if getattr(self, name) not in choices:
                raise InputError(
                    f"'{getattr(self, name)}' is no {name}, expected one of {', '.join(choices)}"
                )

    @property
    def map(self) -> str:
        """Return the name of the map of regions that these modules make."""
        return f"{self.saliency} + {self.segmentation}"

    @property
    def scheme(self) -> str:
        """Return the scheme whose rows show the embedding."""
        return EMBEDDINGS[self.embedding]


FULL = Modules()
# The rows of the paper's ablation table, as near as they can be made here.
PAPER = (
    Modules(saliency="random", segmentation="k_means"),
    Modules(segmentation="fuzzy_c_means", embedding="lsb"),
    Modules(embedding="lsb"),
    FULL,
)


def region_map(surface: Surface, modules: Modules, rng: np.random.Generator) -> Regions:
    """Return the regions of a surface by these modules, as many as it has by default."""
    points, faces = surface.points, surface.faces
    strength, salient = SALIENCY[modules.saliency](points, faces, rng)
    seeds = choose_seeds(points, strength, salient, default_regions(len(points)))
    return SEGMENTATION[modules.segmentation](points, faces, seeds)
