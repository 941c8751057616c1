"""Which damage is looked for on which mesh."""

from __future__ import annotations

import pytest

from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.strategies import STRATEGIES
from tests.keys import KEY
from tests.low_poly import Parts, ball
from tests.shapes import pebble


def applied(model: Parts, effort: str) -> set[str]:
    search = Search(surface=weld(Mesh(*model)), key=KEY, effort=effort)
    return {strategy.name for strategy in STRATEGIES if strategy.applies(search)}


@pytest.mark.parametrize(
    ("model", "undone"),
    [
        (ball(1), set()),  # triangles too long for cells
        (pebble(16), {"restored"}),  # and those of a mesh that an embedding would have marked at its points
        (pebble(24), {"restored", "stretched"}),
        (pebble(40), {"restored", "stretched", "cropped"}),
    ],
)
def test_damage_to_cells_is_undone_where_a_mark_could_be_left(model, undone):
    damage = {"restored", "stretched", "cropped"}
    assert applied(model, "plain") & damage == set()
    assert applied(model, "quick") & damage == undone
    assert applied(model, "wide") & damage == (damage if undone else set())
