"""3MF packages made for tests: each way of writing that the reader must bear."""

from __future__ import annotations

import io
import re
import struct
import zipfile
from typing import Any

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
RELS = (
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Id="r" Target="/3D/Main.model" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)
POINTS = [(0, 0, 0), (10, 0, 0), (0, 20.5, 0), (0, 0, "3.0625e1")]
TRIANGLES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def mesh(points: Any = POINTS, extra: str = "", more: str = "") -> str:
    rows = "\n".join(f' <vertex x="{x}" y="{y}" z="{z}"{more}/>' for x, y, z in points)
    corners = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"{extra}/>' for a, b, c in TRIANGLES)
    return f"<mesh><vertices>\n{rows}\n</vertices><triangles>{corners}</triangles></mesh>"


def model(
    resources: str, build: str = '<item objectid="1"/>', head: str = "", unit: str = "millimeter"
) -> str:
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<model unit="{unit}" xmlns="{CORE}" xmlns:p="{PRODUCTION}">'
        f'{head}<metadata name="Title">caf&#233; &lt;vertices&gt;</metadata>'
        f"<resources>{resources}</resources><build>{build}</build></model>"
    )


def simple(**options: Any) -> str:
    return model(f'<object id="1" type="model">{mesh(**options)}</object>')


def package(main: str, others: dict[str, str] | None = None, method: int = zipfile.ZIP_DEFLATED) -> bytes:
    """A package with odd members: a comment, extra fields, stored and deflated ones, several dates."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.comment = b"a comment"
        members = {"[Content_Types].xml": "<Types/>", "_rels/.rels": RELS, "3D/Main.model": main}
        members |= {"Metadata/thumbnail.png": "\x89PNG" * 50, **(others or {})}
        for number, (name, text) in enumerate(members.items()):
            entry = zipfile.ZipInfo(name, (1990 + number, 2, 3, 4, 5, 6))
            entry.compress_type = method if number % 2 == 0 else zipfile.ZIP_STORED
            entry.extra, entry.comment = struct.pack("<HH4s", 0xCAFE, 4, b"more"), b"of a member"
            archive.writestr(entry, text)
    return packed.getvalue()


OTHER = model(f'<object id="7" type="other">{mesh()}</object>', "")
MODELS = {
    "simple": (simple(), {}),
    "comments": (simple().replace("<vertices>", "<!-- <vertices><vertex x='1'/> --><vertices>"), {}),
    "attribute order": (
        simple().replace("<vertices>\n <vertex x=", "<vertices>\n <vertex  foo='x=\"9\"' x="),
        {},
    ),
    "extras": (simple(extra=' pid="1" p1="0"', more=' p:tag="x"'), {}),
    "closing tags": (simple().replace("/>\n", "></vertex>\n"), {}),
    "single quotes": (simple().replace('"', "'"), {}),
    "prefix": (
        re.sub(r"<(/?)(?=\w)", r"<\1c:", simple()).replace("xmlns=", "xmlns:c=").replace("<c:?xml", "<?xml"),
        {},
    ),
    "inches": (simple().replace("millimeter", "inch"), {}),
    "exponents": (simple(points=[(f"{x:.5e}", f"{y}e0", 1) for x, y, _ in POINTS[:3]] + [(0, 0, "1E2")]), {}),
    "components": (
        model(
            f'<object id="1">{mesh()}</object><object id="2"><components>'
            '<component objectid="1" transform="0 1 0 -1 0 0 0 0 1 5 6 7"/><component objectid="1"/>'
            '<component objectid="1" transform="1 0 0 0 1 0 0 0 0 0 0 0"/></components></object>',
            '<item objectid="2" transform="2 0 0 0 2 0 0 0 2 1 1 1"/><item objectid="1"/>',
        ),
        {},
    ),
    "parts": (
        model(
            f'<object id="1">{mesh()}</object><object id="2"><components>'
            '<component objectid="7" p:path="/3D/Other.model"/></components></object>',
            '<item objectid="2"/><item objectid="1"/><item objectid="7" p:path="/3D/other.model"/>',
        ),
        {"3D/Other.model": OTHER},
    ),
}
