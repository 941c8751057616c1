"""The answer to a caller: what a search found, in words and figures."""

from __future__ import annotations

import numpy as np

from meshmark.coding.chance import believable
from meshmark.coding.codec import Codec
from meshmark.coding.message import PRESENCE, bits_of
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.decoding import Found
from meshmark.ownership.extraction_result import Evidence, Extraction

__all__ = ["extraction_of"]

# A mark of which fewer of its cells still agree is said to be damaged.
LARGELY = 0.7


def extraction_of(found: Found, codec: Codec, mode: str, seconds: float) -> Extraction:
    """Return what a search found in the words and figures of an answer."""
    reading, bound = found.reading, believable(found.log10_false_positive)
    agreeing, lock = 0, 0.0
    if reading is not None:
        agreeing = max((_agreeing(codec, reading, each) for each in found.ids), default=0)
        lock = reading.score / float(reading.keys.weight.sum())
    presence, advice = _in_words(found, mode, agreeing)
    layer = "points" if reading is not None and reading.at_points else "cells"
    ids = tuple(each for each in found.ids if each != PRESENCE)
    shown = ids or ((None,) if found.present else ())
    return Extraction(
        presence=presence,
        id=ids[0] if len(ids) == 1 else None,
        ids=ids,
        bits=bits_of(found.ids[0]) if found.ids else None,
        log10_false_positive=bound,
        mode=mode,
        carriers=found.carriers,
        carriers_agreeing=agreeing,
        lock_score=lock,
        advice=advice,
        seconds=seconds,
        evidence=tuple(Evidence(layer=layer, id=each, log10_false_positive=bound) for each in shown),
    )


def _in_words(found: Found, mode: str, agreeing: int) -> tuple[str, str]:
    """Return presence and advice; agreeing: cells that say the bits of the id.

    The advice is part of what strangers are told: a number that changes with each edit would lead them to the mark.
    """
    if found.combined:
        return (
            "present",
            "Copies with different ids were put together so that they show an id that none of them has; none can "
            "be told.",
        )
    if len(found.ids) > 1:
        return (
            "present",
            f"This is an average of copies with different ids; {len(found.ids)} of them were read.",
        )
    if found.ids and agreeing < LARGELY * found.carriers:
        return (
            "present",
            "The mark was read, though many of its places no longer agree"
            f"{'; it carries no id' if found.ids == (PRESENCE,) else ''}.",
        )
    if found.ids:
        mirrored = found.reading is not None and found.reading.mirrored
        where = " in the mirror image of the model" if mirrored else ""
        none = ", which carries no id" if found.ids == (PRESENCE,) else ""
        return "present", f"The mark was read{where}{none}."
    if found.present:
        return "present", "A mark of this key is there, but too damaged to read its id."
    if found.stopped:
        return (
            "inconclusive",
            "No mark of this key was found before the time limit; not everything was tried.",
        )
    if found.reading is None:
        return "inconclusive", "The model has too few carriers to tell whether it is marked."
    advice = "No mark of this key was found."
    if mode == "blind":
        advice += " For a part or a badly damaged copy, try the certificate or the original."
    return "absent", advice


def _agreeing(codec: Codec, reading: Reading, identity: int) -> int:
    """Return how many cells say the bits of an id, or, of a shape half a step off, the opposite."""
    keys = reading.keys
    bits = np.where(keys.pilot, 0, codec.encode(identity)[keys.code_index])
    agreeing = int(((np.cos(reading.phase) < 0.0) == (bits == 1)).sum())
    return max(agreeing, len(bits) - agreeing)
