"""The package around a 3MF model: which of its parts is the model, and its parts by their addresses."""

from __future__ import annotations

import posixpath
from collections.abc import Mapping

from meshmark.errors import FormatError
from meshmark.io.threemf.xml_text import as_utf8, walk_xml
from meshmark.io.zip_package import Package

__all__ = ["is_3mf", "main_model", "part_name", "read_part"]

_RELATIONSHIP = "http://schemas.openxmlformats.org/package/2006/relationships Relationship"
_RELATIONSHIPS = "_rels/.rels"
_MODEL_TYPE = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
_USUAL_MODEL = "3D/3dmodel.model"
# A part encrypted by the secure content extension begins so.
_SECURE = b"%3McF"


def is_3mf(package: Package) -> bool:
    """Whether a zip file is a 3MF package: a relationship, or the usual name, says which part is its model."""
    try:
        return package.has(_named_model(package))
    except FormatError:
        return False


def main_model(package: Package) -> str:
    """Return the name of the part that the package says is its model. Raises `FormatError`."""
    return package.member(_named_model(package)).filename


def read_part(package: Package, part: str) -> bytes:
    """Return the bytes of a part. Raises `FormatError` where it cannot be read, or is encrypted."""
    content = package.read(part)
    if content.startswith(_SECURE):
        raise FormatError(f"{part} is encrypted (3MF secure content), expected plain content")
    return content


def part_name(target: str) -> str:
    """Return a part's name in the zip file from its address in the package ("/3D/a.model")."""
    return posixpath.normpath(target.strip()).lstrip("/")


def _named_model(package: Package) -> str:
    targets: list[str] = []

    def start(tag: str, attributes: Mapping[str, str], _: int) -> None:
        if tag == _RELATIONSHIP and attributes.get("Type") == _MODEL_TYPE:
            targets.append(attributes.get("Target", ""))

    if package.has(_RELATIONSHIPS):
        text = as_utf8(read_part(package, _RELATIONSHIPS), _RELATIONSHIPS)[0]
        walk_xml(text, _RELATIONSHIPS, start, lambda _: None)
    return part_name(targets[0]) if targets else _USUAL_MODEL
