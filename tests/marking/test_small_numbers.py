"""Marks of a model in small numbers, that bear six decimals, are not seen where no tolerance is named."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from meshmark.geometry.surface_of import surface_of
from meshmark.geometry.visibility import VisibleChange
from meshmark.marking import Embedding, authenticate, embed
from meshmark.mesh import Mesh
from meshmark.strengths import SHOWN_SHARES
from tests.keys import ID, KEY
from tests.shapes import pebble

POINTS, FACES = pebble(72)
SMALL, SMALLISH = 0.03, 0.06


@cache
def marked(tolerance: str | None, size: float = SMALL) -> Embedding:
    return embed(Mesh(size * POINTS, FACES), KEY, id=ID, tolerance=tolerance)


def shown(made: Embedding, size: float = SMALL) -> float:
    surface = surface_of(Mesh(size * POINTS, FACES))
    return VisibleChange(surface.points, surface.faces).of(made.mesh.vertices[surface.vertex_of_point]).share


def test_marks_that_would_be_seen_get_shorter_words():
    made, seen = marked(None, SMALLISH), marked("default", SMALLISH)
    assert made.authentication.tolerance == "default"
    assert "short words" in " ".join(made.remarks)
    assert shown(made, SMALLISH) < SHOWN_SHARES["standard"] < shown(seen, SMALLISH)
    assert made.authentication.payload_bytes < seen.authentication.payload_bytes


def test_where_the_shortest_would_be_seen_those_that_bear_a_grid_are_taken():
    made = marked(None)
    assert made.authentication.tolerance == "web"
    assert "short words" in " ".join(made.remarks)
    assert shown(made) < SHOWN_SHARES["standard"] < shown(marked("default"))


@pytest.mark.parametrize("size", [SMALL, SMALLISH])
@pytest.mark.parametrize("decimals", [6, 7])
def test_they_bear_six_decimals(decimals, size):
    rounded = Mesh(np.round(marked(None, size).mesh.vertices, decimals), FACES)
    assert authenticate(rounded, KEY).verdict == "authentic"


def test_a_tolerance_that_is_named_is_kept():
    made = marked("default")
    assert made.authentication.tolerance == "default"
    assert "short words" not in " ".join(made.remarks)


def test_what_a_named_tolerance_shows_is_said():
    assert f"seen on {shown(marked('default')):.0%} of the surface" in " ".join(marked("default").remarks)


def test_a_model_of_ordinary_numbers_keeps_long_words():
    made = marked(None, 1.0)
    assert made.authentication.tolerance == "default"
    assert "seen" not in " ".join(made.remarks)
