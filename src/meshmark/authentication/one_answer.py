"""One answer from all the evidence: what both layers say, on the whole and on parts, with one bound."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import log10

from meshmark.certificate.binding import mismatch
from meshmark.certificate.certificate import Certificate
from meshmark.coding.chance import believable
from meshmark.coding.keys import Key
from meshmark.coding.message import bits_of, format_id
from meshmark.mesh import Mesh
from meshmark.ownership.extraction_result import Evidence, Extraction
from meshmark.ownership.parameters import PRESENT_LOG10

__all__ = ["one_answer"]

# What each source of evidence may spend of the bound: the ownership layer of the whole, which is the least sure,
# the marks of authentication, and the ownership layer of parts.
_WHOLE, _MARKS, _PARTS = 0.9, 0.05, 0.05


def one_answer(
    found: Extraction,
    marks: Sequence[Evidence],
    parts: Sequence[Evidence] = (),
    *,
    key: Key,
    reference: Certificate | Mesh | None = None,
) -> Extraction:
    """Return the answer of an extraction with what marks of authentication and parts of the surface say besides.

    A union bound holds over all that was looked at: what the ownership layer of the whole says is charged 1 / 0.9,
    what marks or parts say 20 times their own bounds. An id is as sure as its best evidence, and the answer as its
    least sure id. Evidence that is charged out of `PRESENT_LOG10` is none.

    Parameters
    ----------
    found : Extraction
        From the ownership layer of the whole surface.
    marks, parts : sequence of Evidence
        Of the authentication marks, and of the ownership layer of parts of the surface, both over all that was
        tried of each.
    key : Key
    reference : Certificate or Mesh, optional
        That the extraction had; the advice says where it is a certificate of none of the ids.

    Returns
    -------
    Extraction
        `ids` are those of all evidence, the one with the largest share first; `id` is None where they are several.
    """
    own = [entry for entry in found.evidence if entry.id is None or entry.id in found.ids]
    evidence = [*_charged(marks, _MARKS), *_charged(own, _WHOLE), *_charged(parts, _PARTS)]
    ids = _ids(found.ids, evidence)
    if not ids:
        return _without_id(found, evidence)
    bound = max(min(entry.log10_false_positive for entry in evidence if entry.id == each) for each in ids)
    averaged = len(found.ids) > 1 and set(ids) == set(found.ids)
    several = len(ids) > 1 and not averaged
    advice = _parts_in_words(ids, evidence) if several else found.advice
    if not several and not found.ids:
        advice = "The id was read from a part of the model by itself." if parts else _of_marks(found)
    if isinstance(reference, Certificate) and (several or not found.ids):
        remarks = [mismatch(reference, key, each) for each in ids]
        advice += f" {remarks[0]}" if all(remarks) else ""
    return replace(
        found,
        presence="present",
        id=ids[0] if len(ids) == 1 else None,
        ids=ids,
        bits=max(map(bits_of, ids)),
        log10_false_positive=bound,
        evidence=tuple(evidence),
        advice=advice,
    )


def _charged(evidence: Iterable[Evidence], part: float) -> list[Evidence]:
    charged = [
        replace(entry, log10_false_positive=min(believable(entry.log10_false_positive - log10(part)), 0.0))
        for entry in evidence
    ]
    return [entry for entry in charged if entry.log10_false_positive <= PRESENT_LOG10]


def _ids(first: Sequence[int], evidence: Sequence[Evidence]) -> tuple[int, ...]:
    """Return the ids of all evidence, that with the largest share first; of equal ones in the order of `first`."""
    shares: dict[int, float] = {}
    known = {entry.id for entry in evidence}
    for each in first:
        if each in known:
            shares[each] = 0.0
    for entry in evidence:
        if entry.id is not None:
            shares[entry.id] = max(shares.get(entry.id, 0.0), entry.share)
    return tuple(sorted(shares, key=lambda each: -shares[each]))


def _without_id(found: Extraction, evidence: Sequence[Evidence]) -> Extraction:
    if found.presence != "present":
        return found
    if evidence:
        return replace(found, log10_false_positive=evidence[0].log10_false_positive, evidence=tuple(evidence))
    advice = "What was found is not sure enough, given all that was looked at."
    return replace(found, presence="inconclusive", id=None, ids=(), bits=None, evidence=(), advice=advice)


def _of_marks(found: Extraction) -> str:
    beside = "is too damaged to read" if found.evidence else "was not found"
    return (
        f"The id was read from the authentication marks; the ownership mark {beside}. "
        "`meshmark authenticate` tells which parts are as they were signed off."
    )


def _parts_in_words(ids: Sequence[int], evidence: Sequence[Evidence]) -> str:
    """Return a sentence that says which id is read on how much of the surface."""
    said = []
    for each in ids:
        own = [entry for entry in evidence if entry.id == each]
        layers = " and ".join(dict.fromkeys(entry.layer for entry in own))
        said.append(f"{format_id(each)} ({layers}, {100.0 * max(entry.share for entry in own):.0f} %)")
    return f"Parts or layers carry different ids: {', '.join(said[:-1])} and {said[-1]} of the surface."
