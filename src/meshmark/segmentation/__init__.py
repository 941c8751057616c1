"""Map segmentation: a model as regions around its salient points, balanced between its two halves."""

from __future__ import annotations

from meshmark.segmentation.analysis import Segmentation, segment
from meshmark.segmentation.map_segmentation import Regions, map_regions

__all__ = ["Regions", "Segmentation", "map_regions", "segment"]
