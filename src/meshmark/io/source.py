"""From a path to a mesh: the file's bytes, unpacked where gzipped, and the document in them."""

from __future__ import annotations

import io
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from gzip import BadGzipFile, GzipFile
from pathlib import Path
from typing import Any, BinaryIO

from meshmark.errors import FormatError, InputError
from meshmark.io.document import Attributes, Document
from meshmark.io.formats import FORMATS, Format, detect_format
from meshmark.mesh import FloatArray, IntArray, Mesh

__all__ = ["SourceFile", "gzipped", "parse_mesh", "read_mesh", "read_mesh_from"]

_GZIP_MAGIC = b"\x1f\x8b"

# Files beyond this are refused: their arrays would not fit into an ordinary machine's memory.
_MAX_BYTES = 4 << 30
# Text of numbers shrinks up to twentyfold; a small file that grows beyond both limits is a trap.
_MAX_GROWTH = 200
_ALWAYS_ALLOWED = 64 << 20
# A stream is read in parts of so many bytes.
_PART = 1 << 20


@dataclass(frozen=True, eq=False)
class SourceFile:
    """A document together with the file it was read from; itself a `Document`.

    path: where it was read. packed: the bytes of a gzipped file, plain: what was in it; else None.
    """

    path: Path
    document: Document
    packed: bytes | None = None
    plain: bytes | None = None

    @property
    def format(self) -> str:
        """Return the key of the format in `FORMATS`."""
        return self.document.format

    @property
    def vertices(self) -> FloatArray:
        """Return the (n, 3) positions read."""
        return self.document.vertices

    @property
    def faces(self) -> IntArray:
        """Return the (m, 3) triangles."""
        return self.document.faces

    def conform(self, vertices: FloatArray) -> FloatArray:
        """Return the (n, 3) positions that the file would hold for these."""
        return self.document.conform(vertices)

    def patched(self, vertices: FloatArray, name: str) -> Mapping[str, bytes]:
        """Return the files to write; the first is gzipped where `name` ends in `.gz`.

        A gzipped file whose own name does not say so stays gzipped.
        """
        inner = name[:-3] if _says_gzip(name) else name
        files = dict(self.document.patched(vertices, inner))
        if inner == name and (self.packed is None or _says_gzip(self.path.name)):
            return files
        main = files.pop(inner)
        unchanged = self.packed is not None and main == self.plain
        return {name: self.packed if unchanged and self.packed else gzipped(main), **files}

    def attributes(self) -> Attributes:
        """Return what a conversion to another format may keep."""
        return self.document.attributes()

    def summary(self) -> dict[str, Any]:
        """Return what `meshmark info` prints beside counts."""
        return {**self.document.summary(), "gzipped": self.packed is not None}

    def side_files(self) -> tuple[Path, ...]:
        """Return existing files that the file refers to."""
        return self.document.side_files()


def _says_gzip(name: str) -> bool:
    return name.lower().endswith(".gz")


def gzipped(data: bytes) -> bytes:
    """Return `data` gzipped, without name or time: equal data gives equal bytes."""
    out = io.BytesIO()
    with GzipFile(filename="", mode="wb", fileobj=out, mtime=0, compresslevel=6) as packer:
        packer.write(data)
    return out.getvalue()


def read_mesh(path: str | Path) -> Mesh:
    """Read a model file of any format in `FORMATS`, gzipped or not, known by content and by extension.

    The mesh keeps the file's document, into which `write_mesh` patches positions.
    Raises `InputError` for a file that cannot be read, `FormatError` for one that breaks its format;
    each says in one sentence what was expected.
    """
    return parse_mesh(_read_bytes(Path(path)), Path(path))


def read_mesh_from(stream: BinaryIO, format: str, name: str = "standard input") -> Mesh:
    """Read a model of a format, a key of `FORMATS`, from a stream to its end, gzipped or not.

    name: of the stream, for messages; files that the model refers to are looked for in the current folder.
    Raises what `read_mesh` raises.
    """
    if format not in FORMATS:
        raise InputError(f"'{format}' is not a format, expected one of {', '.join(FORMATS)}")
    content = io.BytesIO()
    try:
        while part := stream.read(_PART):
            content.write(part)
            if content.tell() > _MAX_BYTES:
                raise InputError(f"{name} is longer than {_MAX_BYTES >> 30} GB, the most that is read")
    except (OSError, MemoryError) as error:
        raise InputError(f"cannot read {name}: {getattr(error, 'strerror', None) or 'too large'}") from None
    if not content.tell():
        raise FormatError(f"{name} is empty, expected a model")
    return parse_mesh(content.getvalue(), Path(name), FORMATS[format])


def parse_mesh(raw: bytes, path: Path, entry: Format | None = None) -> Mesh:
    """Return the mesh in the bytes of a file; path: for messages and for files beside it.

    entry: the format; known by content and by extension if None. Raises what `read_mesh` raises.
    """
    try:
        plain = _unpacked(raw) if raw.startswith(_GZIP_MAGIC) else raw
        document = (entry or detect_format(plain, path)).parse(plain, path)
        packed = plain is not raw
        source = SourceFile(path, document, raw if packed else None, plain if packed else None)
        return Mesh(document.vertices, document.faces, source)
    except (MemoryError, RecursionError):
        raise InputError(f"{path} is too large or too deeply nested to be read", file=path) from None
    except InputError as error:
        error.file = error.file or str(path)
        if path.name in str(error):
            raise
        raise type(error)(f"{path}: {error}", file=path) from None


def _read_bytes(path: Path) -> bytes:
    try:
        if path.exists() and not path.is_file():
            raise InputError(f"{path} is not a file, expected a model file", file=path)
        if path.is_file() and path.stat().st_size > _MAX_BYTES:
            raise InputError(f"{path} is larger than {_MAX_BYTES >> 30} GB, the most that is read", file=path)
        raw = path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise InputError(f"cannot read {path}: {reason}", file=path) from None
    except MemoryError:
        raise InputError(f"{path} is too large to be read", file=path) from None
    if not raw:
        raise FormatError(f"{path} is empty, expected a model file", file=path)
    return raw


def _unpacked(raw: bytes) -> bytes:
    limit = min(max(_ALWAYS_ALLOWED, _MAX_GROWTH * len(raw)), _MAX_BYTES)
    try:
        with GzipFile(fileobj=io.BytesIO(raw)) as packed:
            plain = packed.read(limit + 1)
    except (BadGzipFile, EOFError, zlib.error) as error:
        raise FormatError(f"the gzip data is damaged ({error})") from None
    if len(plain) > limit:
        raise FormatError(
            f"the gzip data unpacks to more than {limit >> 20} MB, which no model of its size does"
        )
    if not plain:
        raise FormatError("the gzip data is empty, expected a model file")
    return plain
