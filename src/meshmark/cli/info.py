"""`meshmark info`: what a file holds: a model, or a certificate or key of meshmark's own."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from meshmark.cli.model_input import named, read_model
from meshmark.cli.options import AsJson, ModelFormat, ModelFormatIn, ModelIn
from meshmark.cli.output import answer, described, say
from meshmark.cli.paths import STANDARD_INPUT, naming

if TYPE_CHECKING:
    from meshmark.coding.keys import Key

__all__ = ["info"]

_HEAD = 256
_CERTIFICATE = re.compile(rb'\s*\{\s*"format"\s*:\s*"meshmark certificate"')


def info(model: ModelIn, format: ModelFormatIn = None, as_json: AsJson = False) -> int:
    """Tell what a file holds.

    Of a model: its format, its counts, its size, and whether its surface is closed. Of a certificate: what of it is
    public. Of a key: that it is one, and its public fingerprint; the key is never shown.
    """
    fields, key = _fields(model, format)
    width = max(map(len, fields)) + 2
    rows = (
        f"{name.replace('_', ' '):<{width}}{_shown(value)}"
        for name, value in fields.items()
        if name != "remarks"
    )
    answer("\n".join(rows), described(fields, model, key=key), as_json)
    return 0


def _fields(path: Path, format: ModelFormat | None) -> tuple[dict[str, Any], Key | None]:
    """Return what is to be printed, and the key where the file is one."""
    from meshmark.coding.keys import Key, is_key_file

    if path != STANDARD_INPUT and is_key_file(path):
        key = Key.load(path, force=True)
        return {"kind": "meshmark key file", "fingerprint": key.fingerprint}, key
    if path != STANDARD_INPUT and _is_certificate(path):
        from meshmark.marking import Certificate

        return Certificate.load(path).summary(), None
    mesh = read_model(path, format)
    from meshmark.metrics.shape import describe

    document = mesh.document
    held = {} if document is None else {"format": document.format, **document.summary()}
    remarks = () if document is None else document.remarks
    for remark in remarks:
        say(f"meshmark: {named(path)}: {remark}")
    with naming(named(path)):
        return {**held, **describe(mesh).to_dict(), "remarks": remarks}, None


def _is_certificate(path: Path) -> bool:
    """Return whether a file begins as a certificate does, without the slow import of what reads one."""
    try:
        with path.open("rb") as file:
            return _CERTIFICATE.match(file.read(_HEAD)) is not None
    except OSError:
        return False


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
