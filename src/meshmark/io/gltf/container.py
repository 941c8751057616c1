"""The two containers of glTF: a binary .glb of chunks, or a .gltf of JSON with buffers beside or inside it.

Either way the bytes of all buffers are laid end to end in one *blob*; an address is a place in it.
"""

from __future__ import annotations

import base64
import binascii
import re
import struct
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import FormatError
from meshmark.io.gltf.json_text import load_json
from meshmark.io.gltf.schema import Json, integer, objects, text
from meshmark.io.inside import is_link_error, read_inside

__all__ = ["TABLES", "Bytes", "Container", "Segment", "local_name", "open_glb", "open_gltf"]

Bytes = NDArray[np.uint8]

_JSON_CHUNK, _BIN_CHUNK = 0x4E4F534A, 0x004E4942
TABLES = (
    *("scenes", "nodes", "meshes", "accessors", "bufferViews", "buffers"),
    *("materials", "textures", "images", "skins", "animations", "cameras"),
)
_DATA_URI = re.compile(r"data:[^,]*;base64,", re.IGNORECASE)
_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:")
_MOST_BYTES = 2**32


@dataclass(frozen=True, kw_only=True)
class Segment:
    """The bytes of one buffer in the blob, from `start`, `size` of them.

    kind: "chunk" (the binary chunk of a .glb), "uri" (base64 in the JSON), "file" (beside the model).
    name: the file's name relative to the model's folder, for a "file".
    buffers: the indices of the JSON's buffers that use it.
    """

    kind: str
    name: str
    start: int
    size: int
    buffers: tuple[int, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class Container:
    """A glTF file taken apart.

    json_span, chunk_span: the places of the JSON text and of the binary chunk in `raw`.
    tree, tables: the parsed JSON, and its lists of objects by name, empty where absent.
    """

    format: str
    raw: bytes
    path: Path
    json_span: tuple[int, int]
    chunk_span: tuple[int, int] | None
    tree: Json
    tables: dict[str, list[Json]]
    segments: tuple[Segment, ...]
    blob: Bytes

    def view_span(self, view: int) -> tuple[int, int]:
        """Return the address and size in bytes of bufferView `view`."""
        return self.span(self.tables["bufferViews"][view], f"bufferView {view}")

    def span(self, item: Json, where: str) -> tuple[int, int]:
        """Return the address and size of what `item` names by "buffer", "byteOffset" and "byteLength"."""
        buffers = self.tables["buffers"]
        index = integer(item, "buffer", where)
        start, size = integer(item, "byteOffset", where, 0), integer(item, "byteLength", where, None, 1)
        if index >= len(buffers):
            raise FormatError(f"{where}: 'buffer' is {index}, expected an index below {len(buffers)}")
        length = integer(buffers[index], "byteLength", f"buffer {index}", None, 1)
        if start + size > length:
            raise FormatError(f"{where} ends at byte {start + size} of a buffer of {length} bytes")
        segment = next((item for item in self.segments if index in item.buffers), None)
        if segment is None:
            raise FormatError(f"buffer {index} has no data: neither a 'uri' nor a binary chunk")
        return segment.start + start, size


def open_glb(data: bytes, path: Path) -> Container:
    """Take a binary glTF apart. Raises `FormatError` where its chunks do not fit its bytes."""
    if len(data) < 20 or data[:4] != b"glTF":
        raise FormatError(f"{path.name} is not a binary glTF file: no header 'glTF' with a chunk after it")
    version, total = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise FormatError(f"{path.name} is binary glTF version {version}, expected version 2")
    if total > len(data):
        raise FormatError(f"{path.name} is cut off: its header says {total} bytes, it has {len(data)}")
    chunks, at = list[tuple[int, tuple[int, int]]](), 12
    while at < total:
        if at + 8 > total:
            raise FormatError(f"{path.name}: the header of chunk {len(chunks)} is cut off at byte {at}")
        size, kind = struct.unpack_from("<II", data, at)
        if at + 8 + size > total:
            raise FormatError(f"{path.name}: chunk {len(chunks)} of {size} bytes does not fit the file")
        chunks.append((kind, (at + 8, at + 8 + size)))
        at += 8 + size
    if not chunks or chunks[0][0] != _JSON_CHUNK:
        raise FormatError(f"{path.name}: the first chunk is not JSON")
    binary = chunks[1][1] if len(chunks) > 1 and chunks[1][0] == _BIN_CHUNK else None
    return _open("glb", data, path, chunks[0][1], binary)


def open_gltf(data: bytes, path: Path) -> Container:
    """Take a .gltf apart and read the buffers beside it. Raises `FormatError`."""
    return _open("gltf", data, path, (0, len(data)), None)


def _open(
    format_: str, data: bytes, path: Path, json_span: tuple[int, int], chunk: tuple[int, int] | None
) -> Container:
    tree = load_json(data[slice(*json_span)])
    if not isinstance(tree, dict):
        raise FormatError(f"{path.name}: the JSON text is not an object")
    asset = tree.get("asset")
    version = asset.get("version") if isinstance(asset, dict) else None
    if not isinstance(version, str) or not version.startswith("2."):
        raise FormatError(f"{path.name}: 'asset' gives version {version!r}, expected glTF 2.0")
    tables = {key: objects(tree, key) for key in TABLES}
    segments, pieces = _load_buffers(tables["buffers"], path, data, chunk)
    blob = pieces[0] if len(pieces) == 1 else np.concatenate([np.empty(0, np.uint8), *pieces])
    blob.flags.writeable = False
    return Container(
        format=format_,
        raw=data,
        path=path,
        json_span=json_span,
        chunk_span=chunk,
        tree=tree,
        tables=tables,
        segments=segments,
        blob=blob,
    )


def _load_buffers(
    buffers: list[Json], path: Path, data: bytes, chunk: tuple[int, int] | None
) -> tuple[tuple[Segment, ...], list[Bytes]]:
    users: dict[tuple[str, str], list[int]] = {}
    contents: dict[tuple[str, str], Bytes] = {}
    for index, item in enumerate(buffers):
        uri = text(item, "uri", f"buffer {index}")
        if uri is None:
            if index > 0 or chunk is None:
                continue  # a placeholder: an error only where something needs its bytes
            key, content = ("chunk", ""), np.frombuffer(data, np.uint8)[slice(*chunk)]
        elif _DATA_URI.match(uri):
            key, content = ("uri", str(index)), _decoded(uri, index)
        else:
            key = ("file", local_name(uri, f"buffer {index}"))
            content = contents[key] if key in contents else _beside(path, key[1])
        length = integer(item, "byteLength", f"buffer {index}", None, 1)
        if length > len(content):
            raise FormatError(f"buffer {index} has {len(content)} bytes, expected {length} as it declares")
        contents[key] = content
        users.setdefault(key, []).append(index)
    segments, pieces, start = [], [], 0
    for (kind, name), content in contents.items():
        indices = tuple(users[kind, name])
        segments.append(
            Segment(
                kind=kind,
                name=name if kind == "file" else "",
                start=start,
                size=len(content),
                buffers=indices,
            )
        )
        # Each buffer starts at a multiple of 4, so that alignment in the blob is alignment in the buffer.
        pieces += [content, np.zeros(-len(content) % 4, np.uint8)]
        start += len(content) + -len(content) % 4
    return tuple(segments), pieces[:-1]


def _decoded(uri: str, index: int) -> Bytes:
    try:
        return np.frombuffer(base64.b64decode(uri[uri.index(",") + 1 :], validate=True), np.uint8)
    except (binascii.Error, ValueError):
        raise FormatError(f"buffer {index}: the base64 text of its data URI is broken") from None


def local_name(uri: str, where: str) -> str:
    """Return the file that a URI names, relative to the model's folder.

    A backslash counts as a slash, as browsers and Blender have it: exporters on Windows write it.
    Raises `FormatError` for addresses on the network and for paths that lead out of the folder.
    """
    name = unquote(uri).replace("\\", "/")
    parts = PurePosixPath(name).parts
    outside = name.startswith("/") or ".." in parts or "\0" in name or _SCHEME.match(name)
    if outside or not parts:
        shown = uri if len(uri) <= 60 else uri[:57] + "..."
        raise FormatError(f"{where}: the uri {shown!r} is not a file inside the model's own folder")
    return str(PurePosixPath(name))


def _beside(path: Path, name: str) -> Bytes:
    try:
        return np.frombuffer(read_inside(path.parent, name, _MOST_BYTES), np.uint8)
    except FileNotFoundError:
        raise FormatError(f"the buffer {name} that {path.name} refers to is not beside it") from None
    except (OSError, ValueError) as error:
        why = (
            "it is reached through a link" if is_link_error(error) else f"{getattr(error, 'strerror', error)}"
        )
        raise FormatError(f"the buffer {name} that {path.name} refers to cannot be read: {why}") from None
