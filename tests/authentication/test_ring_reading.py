"""How many marks hold by luck: no more than the bound says, whatever the surface is like."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshmark.authentication.checks.ring_reading import beyond_luck, chance_of, read_marks
from meshmark.authentication.checks.setting_search import Setting, all_candidates
from meshmark.authentication.marks.candidates import Candidates, joined
from meshmark.authentication.marks.plan import plan
from meshmark.authentication.marks.ring_shapes import ring_shapes
from meshmark.authentication.marks.rings_of import rings_of
from meshmark.authentication.marks.words import PURPOSE, places_of
from meshmark.authentication.parameters import FINE
from meshmark.coding.keys import Key
from meshmark.geometry.weld import weld
from meshmark.mesh import IntArray, Mesh
from tests.keys import KEY
from tests.low_poly import joined as put_together
from tests.low_poly import sheet, ticks
from tests.shapes import pebble

LAYOUT = next(layout for layout in FINE.layouts if layout.check == 6)
KEYS = [Key(bytes([number]) * 32) for number in range(40)]


def sheets() -> Mesh:
    """Return 150 small open sheets, in all of whose rings there is a boundary."""
    rng = np.random.default_rng(5)
    parts = []
    for number in range(150):
        points, faces = sheet(ticks(3, number), ticks(3, number + 1))
        points = points + 0.05 * rng.normal(size=points.shape) + [1.5 * number, 0.0, 0.0]
        parts.append((points, faces))
    return Mesh(*put_together(parts))


def candidates_of(mesh: Mesh, key: Key) -> Candidates:
    """Return what could be a mark, of steps such as marks have."""
    surface = weld(mesh)
    setting = Setting(
        unit=1e-5 * surface.diagonal, doubt=0.0, layout=LAYOUT, style=FINE, count=0, log10_chance=0.0
    )
    parts = [(group, ring_shapes(surface.points, group)) for group in rings_of(surface)]
    subkey = key.subkey(PURPOSE)
    return joined([all_candidates(surface.points, *part, setting, subkey) for part in parts])


@pytest.mark.parametrize("mesh", [sheets(), Mesh(*pebble(24))], ids=["open", "closed"])
def test_what_holds_without_marks_is_not_beyond_luck(mesh: Mesh) -> None:
    beyond, chances, tried = 0, [], 0
    for number, key in enumerate(KEYS):
        found = candidates_of(mesh, key)
        read = read_marks(found, key, LAYOUT, nonce=number)
        beyond += beyond_luck(found, read.holds, LAYOUT)
        chances.append(chance_of(found, read.holds, LAYOUT))
        tried += int((found.boundary != 0).sum())
    assert (tried > 0) == (mesh.faces.shape[0] == 18 * 150)
    assert beyond <= 4  # one in 30 is expected at most
    assert min(chances) == 0.0


def test_words_that_are_alike_in_rings_that_are_alike_count_once() -> None:
    surface = weld(Mesh(*pebble(32)))
    made = plan(surface, KEY, 1e-6)
    found = made.found.take(np.arange(20))
    words = np.arange(20, dtype=np.uint64)
    whole = places_of(words, found.place, made.layout)
    shifted = whole + np.array(made.layout.radix) * [1, -2, 3]
    rows = np.concatenate([np.arange(20), np.arange(20)])
    twice = found.take(rows)
    held = np.ones(40, bool)
    once = chance_of(_at(found, whole), held[:20], made.layout)
    assert once < 0.0
    assert chance_of(_at(twice, np.concatenate([whole, shifted])), held, made.layout) == once
    assert chance_of(_at(twice, np.concatenate([whole, whole + 1])), held, made.layout) < once


def _at(found: Candidates, whole: IntArray) -> Candidates:
    return replace(found, whole=whole)


def test_the_bound_counts_a_second_try_beside_a_boundary() -> None:
    found = candidates_of(sheets(), KEY)
    held = np.zeros(len(found.vertex), bool)
    held[:400] = True
    once = chance_of(found, held, LAYOUT, without_boundary=False)
    assert once < chance_of(found, held, LAYOUT) < 0.0
