"""A fresh, minimal 3MF package: one object, one build item, millimetres."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from xml.sax.saxutils import quoteattr

import numpy as np

from meshmark.document import Attributes
from meshmark.errors import InputError
from meshmark.mesh import FloatArray, IntArray

__all__ = ["convert_3mf"]

_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_XML = '<?xml version="1.0" encoding="UTF-8"?>\n'
_TYPES = (
    f'{_XML}<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>'
    "</Types>\n"
)
_RELATIONSHIPS = (
    f'{_XML}<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="model" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>\n'
)
_OPENING = '{xml}<model unit="millimeter" xml:lang="en-US" xmlns="{core}">\n<resources>\n'
_CLOSING = '</mesh></object>\n</resources>\n<build><item objectid="1"/></build>\n</model>\n'

# The earliest time a zip file can state: equal meshes give equal bytes.
_NO_TIME = (1980, 1, 1, 0, 0, 0)
_VERTEX = '<vertex x="{0}" y="{0}" z="{0}"/>\n'
_TRIANGLE = '<triangle v1="%d" v2="%d" v3="%d"/>\n'
_ROWS_AT_ONCE = 50_000
# Finer than 32-bit floats: this share of the diagonal is still resolved.
_RESOLUTION = 1e-9


def convert_3mf(
    vertices: FloatArray, faces: IntArray, attributes: Attributes, name: str
) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Return a new 3MF package, and the names of what it does not keep.

    One unit of the mesh is one millimetre. The core specification forbids triangles that name a point
    twice, so these are dropped; normals, texture coordinates and colours are not written.
    """
    corners = np.sort(faces, axis=1)
    whole = (corners[:, 1:] != corners[:, :-1]).all(axis=1)
    if not whole.any():
        raise InputError(
            f"cannot write {name}: 3MF holds no mesh without a triangle of three different points"
        )
    dropped = [*attributes.other]
    fields = {"normals": attributes.normals, "texture coordinates": attributes.texcoords}
    dropped += [
        word for word, value in {**fields, "vertex colours": attributes.colors}.items() if value is not None
    ]
    if not whole.all():
        dropped.append(f"{int((~whole).sum())} triangles that name a point twice")
    model = "".join(_model(vertices, faces[whole], name)).encode()
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for member, content in (
            ("[Content_Types].xml", _TYPES.encode()),
            ("_rels/.rels", _RELATIONSHIPS.encode()),
            ("3D/3dmodel.model", model),
        ):
            entry = zipfile.ZipInfo(member, _NO_TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    return {name: packed.getvalue()}, tuple(dropped)


def _model(vertices: FloatArray, faces: IntArray, name: str) -> Iterator[str]:
    yield _OPENING.format(xml=_XML, core=_CORE)
    title = "".join(letter for letter in name if letter.isprintable())
    yield f'<object id="1" type="model" name={quoteattr(title)}><mesh>\n<vertices>\n'
    # "+ 0.0" turns -0 into 0.
    yield from _rows(_VERTEX.format(_number_form(vertices)), vertices + 0.0)
    yield "</vertices>\n<triangles>\n"
    yield from _rows(_TRIANGLE, faces)
    yield "</triangles>\n"
    yield _CLOSING


def _number_form(vertices: FloatArray) -> str:
    """Return the form of the numbers: as many decimals as the resolution asks for, or full precision."""
    step = _RESOLUTION * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    decimals = int(np.ceil(-np.log10(step))) if 0 < step < np.inf else 99
    return f"%.{max(decimals, 0)}f" if decimals <= 15 else "%.17g"


def _rows(form: str, rows: FloatArray | IntArray) -> Iterator[str]:
    for start in range(0, len(rows), _ROWS_AT_ONCE):
        block = rows[start : start + _ROWS_AT_ONCE]
        yield form * len(block) % tuple(block.ravel().tolist())
