from __future__ import annotations

from pathlib import Path

import pytest

from tests.io.text_samples import SAMPLES


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """Return a small OBJ file."""
    path = tmp_path / "model.obj"
    path.write_bytes(SAMPLES["obj"].data)
    return path
