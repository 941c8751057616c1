"""The answer to a caller: what a search found, in words and figures."""

from __future__ import annotations

import numpy as np

from meshmark.coding.chance import believable
from meshmark.coding.codec import Codec
from meshmark.ownership.decoding import Found
from meshmark.ownership.extraction_result import Evidence, Extraction
from meshmark.ownership.search.measurement import Reading

__all__ = ["extraction_of"]


def extraction_of(found: Found, codec: Codec, mode: str, seconds: float) -> Extraction:
    """Return what a search found in the words and figures of an answer."""
    reading, bound = found.reading, believable(found.log10_false_positive)
    late = "No mark of this key was found before the time limit; not everything was tried."
    if reading is None:
        advice = late if found.stopped else "The model has too few carriers to tell whether it is marked."
        return Extraction(
            presence="inconclusive",
            id=None,
            log10_false_positive=bound,
            mode=mode,
            carriers=0,
            carriers_agreeing=0,
            lock_score=0.0,
            advice=advice,
            seconds=seconds,
        )
    count = len(reading.phase)
    lock = reading.score / float(reading.measured.keys.weight.sum())
    if found.ids:
        agreeing = max(_agreeing(codec, reading, each) for each in found.ids)
        advice = (
            "The mark was read in the mirror image of the model."
            if reading.mirrored
            else "The mark was read."
        )
        if agreeing < 0.7 * count:
            advice = f"The mark was read, though only {agreeing} of its {count} places still agree."
        if len(found.ids) > 1:
            advice = f"This is an average of copies with different ids; {len(found.ids)} of them were read."
        evidence = tuple(Evidence(layer="cells", id=each, log10_false_positive=bound) for each in found.ids)
        return Extraction(
            presence="present",
            id=found.id,
            ids=found.ids,
            log10_false_positive=bound,
            mode=mode,
            carriers=count,
            carriers_agreeing=agreeing,
            lock_score=lock,
            advice=advice,
            seconds=seconds,
            evidence=evidence,
        )
    presence, advice = "absent", "No mark of this key was found."
    if mode == "blind":
        advice += " Of a part or a badly damaged copy the certificate or the original tells more."
    if found.stopped:
        presence, advice = "inconclusive", late
    if found.present:
        presence, advice = "present", "A mark of this key is there, but too damaged to read its id."
    locked = (Evidence(layer="cells", id=None, log10_false_positive=bound),) if found.present else ()
    return Extraction(
        presence=presence,
        id=None,
        log10_false_positive=bound,
        mode=mode,
        carriers=count,
        carriers_agreeing=0,
        lock_score=lock,
        advice=advice,
        seconds=seconds,
        evidence=locked,
    )


def _agreeing(codec: Codec, reading: Reading, identity: int) -> int:
    """Return how many cells say the bits of an id, or, of a shape half a step off, the opposite."""
    keys = reading.measured.keys
    bits = np.where(keys.pilot, 0, codec.encode(identity)[keys.code_index])
    agreeing = int(((np.cos(reading.phase) < 0.0) == (bits == 1)).sum())
    return max(agreeing, len(bits) - agreeing)
