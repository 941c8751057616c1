"""`meshmark info`: what a model file holds."""

from __future__ import annotations

from typing import Any

from meshmark.cli.options import AsJson, ModelIn
from meshmark.cli.output import answer, say
from meshmark.cli.paths import naming

__all__ = ["info"]


def info(model: ModelIn, as_json: AsJson = False) -> int:
    """Tell what a model file holds.

    Its format, its counts, its size, and whether its surface is closed.
    """
    from meshmark.io import read_mesh

    mesh = read_mesh(model)
    from meshmark.metrics.shape import describe

    document = mesh.document
    held = {} if document is None else {"format": document.format, **document.summary()}
    remarks = () if document is None else document.remarks
    with naming(model):
        fields = {**held, **describe(mesh).to_dict()}
    for remark in remarks:
        say(f"meshmark: {model}: {remark}")
    width = max(map(len, fields)) + 2
    rows = (f"{name.replace('_', ' '):<{width}}{_shown(value)}" for name, value in fields.items())
    answer("\n".join(rows), {**fields, "remarks": remarks}, as_json)
    return 0


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, dict):
        return "; ".join(f"{name}: {_shown(entry)}" for name, entry in value.items()) or "none"
    if isinstance(value, list | tuple):
        return ", ".join(_shown(entry) for entry in value) or "none"
    return str(value) if value is not None else "none"
