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
SMALL = 0.03 * POINTS


@cache
def marked(tolerance: str | None, *, small: bool = True) -> Embedding:
    return embed(Mesh(SMALL if small else POINTS, FACES), KEY, id=ID, tolerance=tolerance)


def shown(made: Embedding) -> float:
    surface = surface_of(Mesh(SMALL, FACES))
    return VisibleChange(surface.points, surface.faces).of(made.mesh.vertices[surface.vertex_of_point]).share


def test_marks_that_would_be_seen_give_way_to_those_of_short_words():
    made = marked(None)
    assert made.authentication.tolerance == "web"
    assert "short words" in " ".join(made.remarks)
    assert shown(made) < SHOWN_SHARES["standard"] < shown(marked("default"))


@pytest.mark.parametrize("decimals", [6, 7])
def test_they_bear_six_decimals(decimals):
    rounded = Mesh(np.round(marked(None).mesh.vertices, decimals), FACES)
    assert authenticate(rounded, KEY).verdict == "authentic"


def test_a_tolerance_that_is_named_is_kept():
    made = marked("default")
    assert made.authentication.tolerance == "default"
    assert "short words" not in " ".join(made.remarks)


def test_what_a_named_tolerance_shows_is_said():
    assert f"seen on {shown(marked('default')):.0%} of the surface" in " ".join(marked("default").remarks)


def test_a_model_of_ordinary_numbers_keeps_long_words():
    made = marked(None, small=False)
    assert made.authentication.tolerance == "default"
    assert "seen" not in " ".join(made.remarks)
