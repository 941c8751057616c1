"""Times as strangers may know them."""

from __future__ import annotations

import pytest

from meshmark.coding.elapsed import SECONDS, rounded_up


@pytest.mark.parametrize(
    ("seconds", "said"), [(0.0, 1.0), (1.0, 1.0), (1.01, 3.0), (99.0, 100.0), (1e9, 1000.0)]
)
def test_times_are_rounded_up(seconds, said):
    assert rounded_up(seconds) == said
    assert said in SECONDS
