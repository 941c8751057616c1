"""One model for the tests of schemes that need no other."""

from __future__ import annotations

import pytest

from meshmark.mesh import Mesh
from tests.shapes import pebble


@pytest.fixture(scope="session")
def model() -> Mesh:
    """Return a closed shape of 2,522 vertices."""
    return Mesh(*pebble())
