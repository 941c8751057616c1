"""Is a suspect made of one known copy: a reading by the key, the id and the certificate alone."""

from __future__ import annotations

from dataclasses import dataclass, replace

from meshmark.authentication.reported import marks_evidence
from meshmark.certificate.binding import refuse_edited
from meshmark.certificate.certificate import Certificate
from meshmark.coding.chance import believable
from meshmark.coding.keys import Key
from meshmark.mesh import Mesh
from meshmark.ownership.extraction import find
from meshmark.ownership.parameters import ACCUSED_LOG10
from meshmark.ownership.search.search import Search
from meshmark.scene.surfaces import surfaces_to_read
from meshmark.threads import on_one_thread

__all__ = ["KnownReading", "read_known"]


@dataclass(frozen=True, kw_only=True)
class KnownReading:
    """What says that a suspect is made of a copy.

    log10_chance: bound on the chance that a model which is not made of it reads like this. layer: "authentication"
    or "ownership".
    """

    log10_chance: float
    layer: str


@on_one_thread
def read_known(mesh: Mesh, key: Key, id: int, certificate: Certificate | None = None) -> KnownReading | None:
    """Return what says that a suspect is made of the copy with this id; None where nothing surely does.

    Raises `InputError` where the mesh has no surface, or the certificate of this key was edited.
    """
    if certificate is not None:
        refuse_edited(certificate, key)
    marks = marks_evidence(mesh, key)
    if marks is not None and marks.id == id:
        return KnownReading(log10_chance=marks.log10_false_positive, layer="authentication")
    surfaces = surfaces_to_read(mesh)
    search = Search(surface=next(surfaces), key=key, reference=certificate, copies=surfaces, among=(id,))
    search = replace(search, sure=ACCUSED_LOG10)
    found = find(search)
    bounds = [bound for each, bound in zip(found.ids, found.log10_words, strict=True) if each == id]
    if not bounds or bounds[0] > ACCUSED_LOG10:
        return None
    return KnownReading(log10_chance=believable(bounds[0]), layer="ownership")
