"""Of which copies a suspect was made, by its fingerprint."""

from __future__ import annotations

from meshmark.coding.codec import Codec
from meshmark.ownership.decoding import Found, Listed, lock_bound
from meshmark.ownership.fingerprint.copies_told import copies_told
from meshmark.ownership.fingerprint.fingerprint_reading import read_fingerprint
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.trials import OutOfTimeError

__all__ = ["copies_of"]


def copies_of(search: Search) -> Found | None:
    """Return what the fingerprint of a surface tells, None where there is none that can be read."""
    try:
        reading = read_fingerprint(search)
    except OutOfTimeError:
        return None
    if reading is None:
        return None
    codec = Codec(search.key)
    told = copies_told(codec, reading, Listed(ids=search.among, words=codec.words(search.among)))
    if told is None:
        return None
    return Found(
        reading=reading,
        present=True,
        ids=told.ids,
        log10_false_positive=lock_bound(reading),
        log10_words=told.log10_chances,
        combined=told.combined,
    )
