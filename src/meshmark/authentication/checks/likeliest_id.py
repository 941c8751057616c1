"""The likeliest id of some marks: pieces by the votes of those that carry them, told apart by all the others."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.authentication.checks.ring_reading import read_marks
from meshmark.authentication.marks.candidates import HEADER, Candidates, places_off
from meshmark.authentication.marks.symbols import ids_of_votes
from meshmark.authentication.marks.words import bind, symbols_at
from meshmark.authentication.parameters import Layout
from meshmark.coding.keys import Key
from meshmark.mesh import IntArray

__all__ = ["likeliest_id", "marks_of_ids"]

# Where ids are more than this they are first tried on a few marks, of which some must hold. They are those nearest
# to whole places, most of which are marks.
_MANY, _FIRST, _HOLD = 4096, 4, 2
# The rest is tried on as many marks as make this number of pairs, and the best few ids on a sample of all.
_PAIRS, _LEAST, _MOST, _BEST, _SAMPLE = 60_000, 16, 200, 8, 600


def likeliest_id(found: Candidates, key: Key, layout: Layout, most: int) -> tuple[int | None, int]:
    """Return the id with which most marks hold of those whose pieces are likely, and how many ids were tried.

    Each point has one vote for a piece, which its candidates share. Of pieces that nobody votes for all values are
    tried, as long as they make `most` ids at most. Wrong ids let one mark in 2^check hold, so few marks tell.
    """
    tries = np.bincount(found.vertex)
    header = found.take(found.kind == HEADER)
    read = read_marks(header, key, layout, None)
    header, symbol = header.take(read.holds), read.symbol[read.holds]
    ids = ids_of_votes(header.index, symbol, 1.0 / tries[header.vertex], layout.symbol, most)
    tried = len(ids)
    rest = found.take(found.kind != HEADER)
    if not tried or not len(rest.vertex):
        return None, tried
    near = np.argsort(places_off(rest), kind="stable")
    if tried > _MANY:
        ids = ids[marks_of_ids(rest.take(near[:_FIRST]), key, layout, ids) >= _HOLD]
    if len(ids) > _BEST:
        marks = int(np.clip(_PAIRS // len(ids), _LEAST, _MOST))
        held = marks_of_ids(rest.take(near[:marks]), key, layout, ids)
        ids = ids[np.argsort(-held, kind="stable")[:_BEST]]
    some = rest.take(np.arange(0, len(near), max(len(near) // _SAMPLE, 1)))
    counts = [int(read_marks(some, key, layout, int(each)).holds.sum()) for each in ids]
    return (int(ids[int(np.argmax(counts))]) if counts else None), tried


def marks_of_ids(found: Candidates, key: Key, layout: Layout, ids: NDArray[np.uint64]) -> IntArray:
    """Return (k,): how many of the candidates are marks of each of the ids (k,)."""
    count = len(found.vertex)
    rows = np.tile(np.arange(count), len(ids))
    nonce = np.repeat(ids, count)
    _, holds = symbols_at(found.whole[rows], found.boundary[rows], bind(found.take(rows), key, nonce), layout)
    return np.asarray(holds.reshape(len(ids), count).sum(axis=1), np.int64)
