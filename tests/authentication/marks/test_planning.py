"""Plans that wait for their turn are the same whether they were kept or are made again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshmark.authentication.marks import planning
from meshmark.authentication.marks.plan import plan
from meshmark.authentication.marks.planning import Planned, plans
from meshmark.mesh import Mesh
from tests.counting import some
from tests.keys import KEY
from tests.shapes import pebble


def test_plans_that_are_made_again_are_those_that_would_have_been_kept(monkeypatch: pytest.MonkeyPatch):
    # No plan covers enough, so all wait for the last.
    monkeypatch.setattr(planning, "plan", lambda *given, **named: replace(plan(*given, **named), covered=0.5))
    mesh = Mesh(*pebble(40))
    kept = list(plans(mesh, KEY, None))
    made = planned_times(monkeypatch)
    monkeypatch.setattr(planning, "_LARGE", 0)
    again = list(plans(mesh, KEY, None))
    assert len(again) == len(kept)
    for one, other in some(zip(kept, again, strict=True)):
        assert one.precision == other.precision
        assert (one.plan.marks == other.plan.marks).all()
        assert np.array_equal(one.mesh.vertices, other.mesh.vertices)
    assert len(made) > len(again), "those that were let go of were made twice"


def planned_times(monkeypatch: pytest.MonkeyPatch) -> list[Planned]:
    made: list[Planned] = []
    before = planning._planned

    def counted(*arguments):
        made.append(before(*arguments))
        return made[-1]

    monkeypatch.setattr(planning, "_planned", counted)
    return made
