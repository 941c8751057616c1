"""The model that comes with meshmark: a hare, our own work, made by `tools/make_demo_model.py`."""

from __future__ import annotations

from importlib import resources

__all__ = ["hare_ply"]


def hare_ply() -> bytes:
    """Return the hare as a binary PLY file of 25,178 vertices with colours."""
    from meshmark.data.packing import unpacked

    return unpacked((resources.files("meshmark.data") / "hare.xz").read_bytes())
