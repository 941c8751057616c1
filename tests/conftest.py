"""Fixtures shared by all tests."""

from __future__ import annotations

import gc
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
    "web/server/test_page_in_browser.py", "web/server/test_jobs.py", "marking/test_copies.py",
    "ownership/test_embedding_in_points.py", "research/benchmark/test_run.py", "research/test_every_scheme.py",
    "cli/test_demo.py", "ownership/test_damage.py", "test_docs.py", "ownership/test_embedding.py",
    "cli/test_outputs.py", "ownership/test_extraction_answers.py", "research/benchmark/test_resuming.py",
    "web/test_report_in_browser.py", "marking/test_layers.py", "cli/test_registry_commands.py",
    "authentication/test_as_written.py", "cli/test_batch.py", "authentication/test_web.py",
    "cli/test_authenticate.py", "ownership/test_unsmoothed.py", "cli/test_fewer_bits.py",
    "research/benchmark/test_authentication_bars.py", "research/benchmark/test_page.py", "cli/test_bench.py",
    "recovery/test_repair.py", "ownership/test_embedding_in_parts.py", "cli/test_commands.py",
    "recovery/test_recovery_placing.py", "research/benchmark/test_forging.py",
    "marking/test_both_layers_extraction.py", "authentication/test_small_models.py",
    "authentication/test_rounded.py", "ownership/test_planes_stay_plane.py", "cli/test_bad_models.py",
)  # fmt: skip


# Ways of searching that read the surface as it stands, or by a reference.
CHEAP = {
    "as it stands", "points as they stand", "points after cells", "points after the certificate",
    "registered", "points registered",
}  # fmt: skip


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


def pytest_collection_finish() -> None:
    """Let the garbage collector pass over all that importing and collecting made: it stays until the end."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the development models; tests that use it carry the marker `shared`."""
    if not SHARED_DATA.is_dir():
        pytest.skip("../shared/data is not on this machine")
    return SHARED_DATA


@pytest.fixture(scope="session")
def model() -> Mesh:
    """Return a closed shape of 1,626 vertices, for the tests that need no other."""
    return Mesh(*pebble(58))


@pytest.fixture
def short_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a search read the surface as it stands and by a reference only; tests/ownership has all ways."""
    from meshmark.ownership import extraction

    kept = tuple(way for way in extraction.STRATEGIES if way.name in CHEAP)
    assert len(kept) == len(CHEAP)
    monkeypatch.setattr(extraction, "STRATEGIES", kept)


@pytest.fixture
def drafts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw pictures with one sample for each pixel, those of pages small; tests/report looks at finished ones."""
    from meshmark.report import picture, still_view

    monkeypatch.setattr(picture, "FINER", 1)
    monkeypatch.setattr(still_view, "SIZE", 160)
