"""Of which copies a suspect was made, by its fingerprint, before and beside what its cells and points say."""

from __future__ import annotations

from meshmark.coding.codec import Codec
from meshmark.ownership.decoding import Found, Listed, lock_bound
from meshmark.ownership.extraction import find
from meshmark.ownership.fingerprint.copies_told import copies_told
from meshmark.ownership.fingerprint.fingerprint_reading import read_fingerprint
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.trials import OutOfTimeError

__all__ = ["copies_of", "find_copies"]


def find_copies(search: Search) -> Found:
    """Return what `find` does, unless the fingerprint tells several ids, or that no id explains it.

    Cells read the sum of three words as clearly as one, and an average of two as nothing. Where they tell nothing
    and the fingerprint one id, it is that.
    """
    told = copies_of(search)
    if told is not None and len(told.ids) != 1:
        return told
    found = find(search)
    return told if told is not None and not found.ids else found


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
