"""Saliency of a mesh: NC-DGG beta per vertex and the salient points."""

from __future__ import annotations

from meshmark.saliency.analysis import SaliencyResult, analyse
from meshmark.saliency.nc_dgg import Saliency, saliency
from meshmark.saliency.salient_points import salient_points

__all__ = ["Saliency", "SaliencyResult", "analyse", "saliency", "salient_points"]
