"""Fixtures shared by all tests."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import settings

SHARED_DATA = Path(__file__).resolve().parents[2] / "shared" / "data"

# How long an example takes depends on what else the machine does.
settings.register_profile("meshmark", deadline=None)
settings.load_profile("meshmark")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave out the tests that need ../shared/data where it is absent, and say so."""
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
