"""Fixtures shared by all tests."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import settings

from meshmark.mesh import Mesh
from tests.shapes import pebble

SHARED_DATA = Path(__file__).resolve().parents[2] / "shared" / "data"

# How long an example takes depends on what else the machine does.
settings.register_profile("meshmark", deadline=None)
settings.load_profile("meshmark")


# The files that take longest, the slowest first. Several processes take files in this order, so that none is left
# with a long one in the end (`make test`; seconds of processor time: `pytest --durations`).
SLOWEST = (
    "research/test_every_scheme.py", "test_docs.py", "ownership/test_damage.py", "cli/test_demo.py",
    "cli/test_authenticate.py", "cli/test_commands.py", "cli/test_bad_models.py", "marking/test_layers.py",
    "marking/test_copies.py", "cli/test_outputs.py", "recovery/test_repair.py", "ownership/test_embedding.py",
    "ownership/test_embedding_in_points.py", "cli/test_low_poly.py",
    "ownership/test_unsmoothed.py", "research/benchmark/test_resuming.py", "research/benchmark/test_page.py",
    "research/benchmark/test_plots.py",
)  # fmt: skip


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the slowest files first; leave out the tests that need ../shared/data where it is absent, and say so."""
    here = Path(__file__).parent
    rank = {here / name: number for number, name in enumerate(SLOWEST)}
    items.sort(key=lambda item: rank.get(item.path, len(rank)))
    if SHARED_DATA.is_dir():
        return
    skip = pytest.mark.skip(reason="../shared/data is not on this machine")
    for item in items:
        if "shared" in item.keywords:
            item.add_marker(skip)


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the development models; tests that use it carry the marker `shared`."""
    if not SHARED_DATA.is_dir():
        pytest.skip("../shared/data is not on this machine")
    return SHARED_DATA


@pytest.fixture(scope="session")
def model() -> Mesh:
    """Return a closed shape of 2,382 vertices, for the tests that need no other."""
    return Mesh(*pebble(70))
