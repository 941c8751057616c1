"""Libraries that a test needs and that no extra of the development tools installs."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

__all__ = ["need_gpytoolbox"]


def need_gpytoolbox() -> None:
    """Leave the test out where gpytoolbox is absent, which caps the versions of numpy and scipy."""
    if find_spec("gpytoolbox") is None:
        pytest.skip("gpytoolbox is not installed: pip install 'meshmark[remesh]'")
