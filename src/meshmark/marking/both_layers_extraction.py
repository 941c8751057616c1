"""Extraction from both layers: presence, id and one bound, by the key alone or with a reference."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import log10
from time import monotonic, perf_counter

import numpy as np

from meshmark.authentication.one_answer import one_answer
from meshmark.authentication.reported import evidence_of_marks
from meshmark.certificate.certificate import Certificate
from meshmark.coding.chance import believable
from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.geometry.surface import Surface
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.ownership.answer import extraction_of
from meshmark.ownership.extraction import checked_request, find
from meshmark.ownership.extraction import extract as extract_ownership
from meshmark.ownership.extraction_result import Evidence, Extraction
from meshmark.ownership.large_components import MOST_READ, large_components
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.trials import TrialCounter
from meshmark.scene.surfaces import marked_surface
from meshmark.threads import on_one_thread

__all__ = ["extract"]

# Where marks vouch for this share of the surface, the ownership layer, too, is read as it stands only.
_MOSTLY_WHOLE = 0.2
# Seconds that a search is given at least, however long the marks took.
_LEAST_TIME = 0.01


@on_one_thread
def extract(
    mesh: Mesh,
    key: Key,
    *,
    reference: Certificate | Mesh | None = None,
    search: str = "quick",
    time_limit: float | None = None,
    cut: bool = False,
    among: Sequence[int] = (),
) -> Extraction:
    """Read the id from a mesh with the key alone, or with a reference as well, from both layers.

    The marks of authentication are asked first: they take little time and survive every cut. Where they report ids
    on most of the surface the ownership layer is read as it stands, else by the whole search. Where the two do not
    agree on one id, connected components are read on their own as well. `one_answer` says what the bound covers.

    Parameters
    ----------
    mesh : Mesh
        The suspect.
    key : Key
    reference : Certificate or Mesh, optional
        The certificate that was made at embedding, or the unmarked original: the ownership layer is then also read
        where they say that the suspect lies.
    search : str
        "plain" reads the surface as it stands, "quick" also undoes common damage, "wide" also exchanges axes that
        are nearly alike and reads every spacing instead of the first few.
    time_limit : float, optional
        Seconds after which the search of the ownership layer stops; the answer is "inconclusive" where no mark was
        found by then.
    cut : bool
        Also look for copies of one mesh that have lost a piece.
    among : sequence of int, optional
        Ids of which one may be there: it takes less evidence of the ownership layer to tell it from these than from
        all 2^64, and averages of more than two copies name those of them that took part.

    Returns
    -------
    Extraction
        `evidence` says which layer said what of which share of the surface.

    Raises
    ------
    InputError
        The search is unknown, the time limit not above 0, an id has more than 64 bits, the certificate of this key
        was edited, or the mesh has no surface.
    """
    checked_request(key, reference, search=search, time_limit=time_limit)
    start, end = perf_counter(), None if time_limit is None else monotonic() + time_limit
    marks = evidence_of_marks(mesh, key)
    mostly_whole = sum(entry.share for entry in marks) >= _MOSTLY_WHOLE
    found = extract_ownership(
        mesh,
        key,
        reference=reference,
        search="plain" if mostly_whole else search,
        time_limit=_left(end),
        cut=cut,
        among=among,
        copies=not mostly_whole,  # marks of authentication do not survive that copies are put together
    )
    agreed = (len(found.ids) == 1 or found.bits == 0) and all(entry.id == found.id for entry in marks)
    averaged = len(found.ids) > 1 and not marks
    parts = () if agreed or averaged else tuple(_parts(mesh, key, end, among))
    result = one_answer(found, marks, parts, key=key, reference=reference)
    return replace(result, seconds=perf_counter() - start)


def _left(end: float | None) -> float | None:
    """Return how many seconds are left until `end`, at least a few."""
    return None if end is None else max(end - monotonic(), _LEAST_TIME)


def _parts(mesh: Mesh, key: Key, end: float | None, among: Sequence[int]) -> Iterator[Evidence]:
    """Yield what the ownership layer of large connected components says, each read as it stands.

    The bound of the t-th is multiplied by t (t + 1), for all of them together.
    """
    surface = marked_surface(mesh)
    areas = surface.face_areas
    for trial, component in enumerate(large_components(surface, MOST_READ), start=1):
        if end is not None and monotonic() >= end:
            return
        chosen = component[surface.faces[:, 0]]
        search = Search(
            surface=surface_of(_mesh_of(surface, chosen)),
            key=key,
            effort="plain",
            trials=TrialCounter(_left(end)),
            among=tuple(dict.fromkeys(among)),
        )
        found = extraction_of(find(search), Codec(key), "blind", 0.0)
        charge = log10(trial * (trial + 1))
        for entry in found.evidence:
            yield replace(
                entry,
                log10_false_positive=believable(entry.log10_false_positive + charge),
                share=float(areas[chosen].sum() / areas.sum()),
            )


def _mesh_of(surface: Surface, chosen: np.ndarray) -> Mesh:
    """Return the mesh of the chosen faces (m,) of a surface."""
    rows, corners = np.unique(surface.faces[chosen], return_inverse=True)
    return Mesh(surface.points[rows], corners.reshape(-1, 3))
