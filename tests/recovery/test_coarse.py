from __future__ import annotations

import numpy as np
import pytest

from meshmark.errors import CapacityError
from meshmark.recovery import coarse
from tests.shapes import pebble


def test_a_large_model_is_simplified_to_the_same_in_a_process_of_its_own(monkeypatch):
    points, faces = pebble(60)
    here = coarse.coarse_surface(points, faces, 300)
    monkeypatch.setattr(coarse, "LARGE", 100)
    there = coarse.coarse_surface(points, faces, 300)
    assert len(here[1]) < len(faces) / 2
    np.testing.assert_array_equal(there[0], here[0])
    np.testing.assert_array_equal(there[1], here[1])


def test_a_process_that_fails_is_said_so(monkeypatch, tmp_path):
    failing = tmp_path / "child.py"
    failing.write_text("raise SystemExit(3)")
    monkeypatch.setattr(coarse, "LARGE", 100)
    monkeypatch.setattr(coarse, "CHILD", failing)
    with pytest.raises(CapacityError, match="ended with 3"):
        coarse.coarse_surface(*pebble(60), 300)
