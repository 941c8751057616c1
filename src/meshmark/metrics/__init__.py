"""How much models differ and how well a mark was read: one function per measure, and the table of them."""

from __future__ import annotations

from meshmark.metrics.comparison import Comparison, compare
from meshmark.metrics.table import METRICS, Metric

__all__ = ["METRICS", "Comparison", "Metric", "compare"]
