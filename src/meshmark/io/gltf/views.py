"""The bufferViews of a glTF with some of them given new bytes, laid out anew in a single buffer."""

from __future__ import annotations

import base64
import json
import struct
from dataclasses import replace
from typing import Any
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.container import TABLES, Bytes, Container, Segment
from meshmark.io.gltf.schema import Json, objects

__all__ = ["MESHOPT", "Views", "extension", "with_one_buffer"]

MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
_ROWS, _INDICES = 34962, 34963


def extension(item: Json, name: str) -> Json | None:
    """Return the object of an extension in a part of the JSON, or None where it has none."""
    extensions = item.get("extensions")
    found = extensions.get(name) if isinstance(extensions, dict) else None
    return found if isinstance(found, dict) else None


def forget(item: Json, *names: str) -> None:
    """Take extensions out of a part of the JSON."""
    extensions = item.get("extensions")
    if isinstance(extensions, dict):
        item["extensions"] = {key: value for key, value in extensions.items() if key not in names}
        if not item["extensions"]:
            del item["extensions"]


class Views:
    """The bufferViews of `tree`, a copy of the container's that may be changed, and the bytes of each."""

    def __init__(self, container: Container, tree: Json) -> None:
        self.container, self.records = container, objects(tree, "bufferViews")
        tree["bufferViews"] = self.records
        self.contents: dict[int, Bytes] = {}

    def fill(self, view: int, rows: NDArray[Any]) -> None:
        """Give a bufferView new bytes, rows as they are stored."""
        self.contents[view] = np.ascontiguousarray(rows).view(np.uint8).reshape(-1)

    def fill_indices(self, view: int, indices: NDArray[Any]) -> None:
        """Give a bufferView indices."""
        self.fill(view, indices)
        self.records[view].pop("byteStride", None)
        self.records[view]["target"] = _INDICES

    def add(self, rows: NDArray[Any]) -> int:
        """Return the number of a new bufferView with rows (n, width) of a vertex attribute, or (n,) indices."""
        self.records.append({"target": _INDICES if rows.ndim == 1 else _ROWS})
        number = len(self.records) - 1
        if rows.ndim == 1:
            self.fill(number, rows)
            return number
        size = rows.shape[1] * rows.dtype.itemsize
        padded = np.zeros((len(rows), size + -size % 4), np.uint8)
        padded[:, :size] = np.ascontiguousarray(rows).view(np.uint8).reshape(len(rows), size)
        self.records[number]["byteStride"] = padded.shape[1]
        self.fill(number, padded)
        return number

    def laid_out(self) -> Bytes:
        """Return the bytes of all views, one behind the other, and say in the records where each lies."""
        pieces: list[Bytes] = []
        placed: dict[tuple[int, int], int] = {}
        end = 0
        for number, record in enumerate(self.records):
            content, phase, key = self.contents.get(number), 0, (-1 - number, 0)
            if content is None:
                key = start, size = self.container.view_span(number)
                # Components stand at multiples of their size, counted from the start of the buffer.
                content, phase = self.container.blob[start : start + size], start % 4
            if key not in placed:
                gap = (phase - end) % 4
                pieces += [np.zeros(gap, np.uint8), content]
                placed[key] = end + gap
                end += gap + len(content)
            record.update(buffer=0, byteOffset=placed[key], byteLength=len(content))
            forget(record, *MESHOPT)
        return np.concatenate([*pieces, np.zeros(-end % 4, np.uint8)])


def with_one_buffer(container: Container, tree: Json, views: Views) -> Container:
    """Return a container of the same kind for the changed JSON, with all `views` in one buffer.

    A .gltf with a buffer beside it keeps it there under the first such name, else inside as base64. The bounds that
    the JSON gives for accessors become those of the new bytes.
    """
    blob = views.laid_out()
    first = container.tables["buffers"][0] if container.tables["buffers"] else {}
    tree["buffers"] = [
        {**{key: first[key] for key in ("name", "extras") if key in first}, "byteLength": len(blob)}
    ]
    tables = {key: objects(tree, key) for key in TABLES}
    files = [item.name for item in container.segments if item.kind == "file"]
    if container.format == "glb":
        kind = "chunk"
    elif files:
        kind = "file"
        tree["buffers"][0]["uri"] = quote(files[0])
    else:
        kind = "uri"
        text64 = base64.b64encode(blob.tobytes()).decode()
        tree["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{text64}"
    blob.flags.writeable = False
    segment = Segment(
        kind=kind, name=files[0] if kind == "file" else "", start=0, size=len(blob), buffers=(0,)
    )
    plain = replace(container, tree=tree, tables=tables, segments=(segment,), blob=blob)
    _set_bounds(plain, set(views.contents))
    text = json.dumps(tree, separators=(",", ":")).encode()
    if kind != "chunk":
        return replace(plain, raw=text, json_span=(0, len(text)))
    return _as_glb(plain, text + b" " * (-len(text) % 4))


def _as_glb(plain: Container, text: bytes) -> Container:
    raw, (_, end) = plain.raw, plain.chunk_span or plain.json_span
    # Chunks behind the two that the specification knows stay, as does what lies behind the last.
    chunks = raw[end : struct.unpack_from("<I", raw, 8)[0]]
    start = 28 + len(text)
    total = start + len(plain.blob) + len(chunks)
    head = struct.pack("<4sIII4s", b"glTF", 2, total, len(text), b"JSON") + text
    body = struct.pack("<I4s", len(plain.blob), b"BIN\0") + plain.blob.tobytes()
    return replace(
        plain,
        raw=head + body + raw[end:],
        json_span=(20, 20 + len(text)),
        chunk_span=(start, start + len(plain.blob)),
    )


def _set_bounds(container: Container, changed: set[int]) -> None:
    for number, item in enumerate(container.tables["accessors"]):
        view = item.get("bufferView")
        if not isinstance(view, int) or view not in changed or not ({"min", "max"} & item.keys()):
            continue
        try:
            accessor = open_accessor(container, number)
        except FormatError:
            continue  # named where somebody needs it
        rows = accessor.raw(container.blob)
        if rows.dtype.kind == "f" and not np.isfinite(rows).all():
            continue
        item["min"], item["max"] = rows.min(axis=0).tolist(), rows.max(axis=0).tolist()
