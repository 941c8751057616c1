"""Writing a changed blob back into its container: bounds, base64, file names, lengths, and not a byte more."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Collection, Iterator
from pathlib import PurePosixPath
from typing import Any
from urllib.parse import quote

import numpy as np

from meshmark.errors import FormatError
from meshmark.io.gltf.accessor import open_accessor
from meshmark.io.gltf.container import Bytes, Container, Segment, local_name
from meshmark.io.gltf.json_text import locate, replace
from meshmark.io.gltf.uses import position_accessors

__all__ = ["rebuild", "referenced_files", "referenced_images"]

_Path = tuple[str | int, ...]


def rebuild(container: Container, blob: Bytes, name: str, held: Collection[str]) -> dict[str, bytes]:
    """Return the files to write for a blob with moved positions, the model first, called `name`.

    held: the buffers beside the model that hold positions; others are side files and not returned.

    A buffer beside the model keeps its name where the model keeps its own (so the save goes to another
    folder); else it gets one made from the model's, so that the original's buffer, and the buffers of
    other copies in that folder, are never written over.
    """
    edits = dict(_bounds(container, blob))
    files: dict[str, bytes] = {}
    for segment in container.segments:
        content = _content(blob, segment)
        changed = content != _content(container.blob, segment)
        if segment.kind == "file" and segment.name in held:
            target = _new_name(container, segment, name) if changed else segment.name
            files[target] = content
            if target != segment.name:
                edits |= {("buffers", i, "uri"): json.dumps(quote(target)).encode() for i in segment.buffers}
        elif segment.kind == "uri" and changed:
            edits |= _base64(container, segment, content)
    text = _edited(container.raw[slice(*container.json_span)], edits)
    return {name: text if container.format == "gltf" else _glb(container, text, blob), **files}


def referenced_files(container: Container) -> list[str]:
    """Return the local files that images and unloaded buffers name, relative to the model's folder."""
    return list(dict.fromkeys([*_local_names(container, "buffers"), *_local_names(container, "images")]))


def referenced_images(container: Container) -> frozenset[str]:
    """Return the local files that images alone name, relative to the model's folder."""
    return frozenset(_local_names(container, "images")) - frozenset(_local_names(container, "buffers"))


def _local_names(container: Container, key: str) -> list[str]:
    names = []
    for item in container.tables[key]:
        uri = item.get("uri")
        if isinstance(uri, str) and not uri.startswith("data:"):
            try:
                names.append(local_name(uri, key))
            except FormatError:
                continue  # an address elsewhere stays valid wherever the model is saved
    return names


def _content(blob: Bytes, segment: Segment) -> bytes:
    return blob[segment.start : segment.start + segment.size].tobytes()


def _new_name(container: Container, segment: Segment, name: str) -> str:
    if name == container.path.name.removesuffix(".gz"):
        return segment.name
    taken = set(referenced_files(container))
    old, stem = PurePosixPath(segment.name), PurePosixPath(name).stem
    files = [item for item in container.segments if item.kind == "file"]
    number = str(files.index(segment)) if len(files) > 1 else ""
    target = old.with_name(f"{stem}{number}{old.suffix}")
    while str(target) in taken:
        target = target.with_name(f"{target.stem}_{target.suffix}")
    return str(target)


def _bounds(container: Container, blob: Bytes) -> Iterator[tuple[_Path, bytes]]:
    """Yield the numbers of `min` and `max` to write for each POSITION accessor whose rows changed."""
    for index in position_accessors(container):
        if index >= len(container.tables["accessors"]):
            continue
        try:
            accessor = open_accessor(container, index)
        except FormatError:
            continue  # broken, and nothing that is shown uses it
        rows = accessor.raw(blob)
        if accessor.raw(container.blob).tobytes() == rows.tobytes():
            continue
        for key, bound in (("min", rows.min(axis=0)), ("max", rows.max(axis=0))):
            declared = container.tables["accessors"][index].get(key)
            if not isinstance(declared, list) or len(declared) != accessor.width:
                continue
            for axis, (old, new) in enumerate(zip(declared, bound, strict=True)):
                if not _says(old, new):
                    yield ("accessors", index, key, axis), repr(new.item()).encode()


def _says(declared: Any, value: np.number[Any]) -> bool:
    """Whether a number in the JSON stands for a stored component: floats are read as 32-bit ones."""
    if not isinstance(declared, (int, float)) or abs(declared) > 1e300:
        return False
    if value.dtype.kind != "f":
        return bool(declared == value.item())
    with np.errstate(over="ignore"):
        return bool(np.float64(declared).astype(value.dtype) == value)


def _base64(container: Container, segment: Segment, content: bytes) -> dict[_Path, bytes]:
    index = segment.buffers[0]
    uri: str = container.tables["buffers"][index]["uri"]
    new = uri[: uri.index(",") + 1] + base64.b64encode(content).decode()
    return {("buffers", index, "uri"): json.dumps(new).encode()}


def _edited(text: bytes, edits: dict[_Path, bytes]) -> bytes:
    if not edits:
        return text
    changes = []
    for path, span in locate(text, edits.keys()).items():
        new = edits[path]
        # Some writers spell "/" as "\/" in strings: keep their way, so that equal base64 stays equal.
        if b"\\/" in text[slice(*span)]:
            new = new.replace(b"/", b"\\/")
        changes.append((span, new))
    return replace(text, changes)


def _glb(container: Container, text: bytes, blob: Bytes) -> bytes:
    raw, (start, end) = container.raw, container.json_span
    old = raw[start:end]
    if text != old:
        # The chunk is filled up with spaces to a multiple of 4; extra whole words of padding stay.
        body = text.rstrip(b" ")
        padding = (len(old) - len(old.rstrip(b" "))) // 4 * 4 + -len(body) % 4
        text = body + b" " * padding
    total = struct.unpack_from("<I", raw, 8)[0] + len(text) - len(old)
    header = raw[:8] + struct.pack("<II", total, len(text)) + raw[16:20]
    if container.chunk_span is None:
        return header + text + raw[end:]
    first, last = container.chunk_span
    chunk = next((item for item in container.segments if item.kind == "chunk"), None)
    content = raw[first:last] if chunk is None else _content(blob, chunk)
    return b"".join([header, text, raw[end:first], content, raw[last:]])
