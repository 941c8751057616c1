"""From a path to a mesh: the file's bytes, unpacked where gzipped, and the document in them."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from meshmark.document import Attributes, Deviation, Document
from meshmark.errors import FormatError, InputError
from meshmark.io.formats import FORMATS, Format, detect_format
from meshmark.io.gzip_data import GZIP_MAGIC, MOST_BYTES, gzipped, unpacked
from meshmark.io.wording import amount
from meshmark.mesh import FloatArray, IntArray, Mesh

if TYPE_CHECKING:
    from meshmark.io.archive import Archive

__all__ = ["SourceFile", "parse_mesh", "read_mesh", "read_mesh_from"]

_ZIP_MAGIC = b"PK\x03\x04"

# A stream is read in parts of this many bytes.
_PART = 1 << 20


@dataclass(frozen=True, eq=False, kw_only=True)
class SourceFile:
    """A document together with the file it was read from; itself a `Document`.

    path: where it was read. packed: the bytes of a gzipped file, plain: what was in it; else None.
    archive: the zip archive that holds the model, or None. tail: what follows the gzip data.
    """

    path: Path
    document: Document
    packed: bytes | None = None
    plain: bytes | None = None
    archive: Archive | None = None
    tail: bytes = b""

    @property
    def format(self) -> str:
        """Return the key of the format in `FORMATS`."""
        return self.document.format

    @property
    def vertices(self) -> FloatArray:
        """Return the (n, 3) positions read."""
        return self.document.vertices

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return what the user should know of how the file was read."""
        outer: tuple[str, ...] = () if self.archive is None else (self.archive.remark,)
        if self.tail:
            count = amount(len(self.tail), "byte follows", "bytes follow")
            outer += (f"{count} the gzip data, and {'is' if len(self.tail) == 1 else 'are'} kept",)
        return outer + self.document.remarks

    @property
    def faces(self) -> IntArray:
        """Return the (m, 3) triangles."""
        return self.document.faces

    def conform(self, vertices: FloatArray) -> FloatArray:
        """Return the (n, 3) positions that the file would hold for these."""
        return self.document.conform(vertices)

    def patched(self, vertices: FloatArray, name: str) -> Mapping[str, bytes]:
        """Return the files to write; the first is gzipped where `name` ends in `.gz`.

        A gzipped file whose own name does not say so stays gzipped. A model from a zip archive goes back into it
        where `name` ends in `.zip`, or neither name does. Raises `InputError` for such a name without an archive.
        """
        if self._in_archive(name) and self.archive is not None:
            (main,) = self.document.patched(vertices, self.archive.name).values()
            return {name: self.archive.holding(main)}
        if _says_zip(name):
            raise InputError(f"cannot write {name}: a zip archive is only written where one was read")
        inner = name[:-3] if _says_gzip(name) else name
        files = dict(self.document.patched(vertices, inner))
        if inner == name and (self.packed is None or _says_gzip(self.path.name)):
            return files
        main = files.pop(inner)
        unchanged = self.packed is not None and main == self.plain
        return {name: self.packed if unchanged and self.packed else gzipped(main) + self.tail, **files}

    def left_behind(self, name: str) -> tuple[str, ...]:
        """Return what of the archive a file of this name does not hold."""
        if self.archive is None or not self.archive.others or self._in_archive(name):
            return ()
        return ("other files in the zip archive",)

    def _in_archive(self, name: str) -> bool:
        return self.archive is not None and (_says_zip(name) or not _says_zip(self.path.name))

    def decompressed(self, vertices: FloatArray) -> tuple[str, ...]:
        """Return the extensions that compress this file but not what `patched` gives for these positions."""
        names = tuple(self.document.summary().get("compression", ()))
        return () if np.array_equal(vertices, self.vertices) else names

    def recompressed(self, files: Mapping[str, bytes], name: str, names: Sequence[str]) -> dict[str, bytes]:
        """Return the files that `patched` gave, the model being `name`, compressed where it was by `names`."""
        if not names:
            return dict(files)
        from meshmark.io.gltf.repack import repacked

        packed = files[name].startswith(GZIP_MAGIC)
        plain = {**files, name: unpacked(files[name])[0]} if packed else files
        found = repacked(plain, name, self.format)
        return {**found, name: gzipped(found[name])} if packed else found

    def check_recompression(self) -> None:
        """Raise `InputError` for a file that is not compressed, or by an extension that nothing here writes."""
        names = self.document.summary().get("compression", ())
        if not names:
            raise InputError(f"{self.path.name} is not compressed, expected no --recompress")
        from meshmark.io.gltf.repack import check_encoders

        check_encoders(names)

    def attributes(self) -> Attributes:
        """Return what a conversion to another format may keep."""
        return self.document.attributes()

    def summary(self) -> dict[str, Any]:
        """Return what `meshmark info` prints beside counts."""
        return {**self.document.summary(), "gzipped": self.packed is not None}

    def deviations(self) -> tuple[Deviation, ...]:
        """Return in which ways a viewer shows something else than the surface."""
        return self.document.deviations()

    def looks(self) -> tuple[str, ...] | None:
        """Return what the surface is painted with."""
        return self.document.looks()

    def side_files(self) -> tuple[Path, ...]:
        """Return existing files that the file refers to."""
        return self.document.side_files()


def _says_zip(name: str) -> bool:
    return name.lower().endswith(".zip")


def _archive(data: bytes, path: Path) -> Archive | None:
    if not data.startswith(_ZIP_MAGIC):
        return None
    from meshmark.io.archive import open_archive  # slow to import, and seldom needed

    return open_archive(data, path)


def _says_gzip(name: str) -> bool:
    return name.lower().endswith(".gz")


def read_mesh(path: str | Path) -> Mesh:
    """Read a model file of any format in `FORMATS`, gzipped or not, known by content and by extension.

    Parameters
    ----------
    path : str or Path
        The file; other files that it refers to are looked for beside it.

    Returns
    -------
    Mesh
        The surface, n vertices in the order of the file. It keeps the file's document, into which `write_mesh`
        patches positions.

    Raises
    ------
    InputError
        The file cannot be read.
    FormatError
        The file breaks its format; the message says where, and what was expected.
    """
    return parse_mesh(_read_bytes(Path(path)), Path(path))


def read_mesh_from(stream: BinaryIO, format: str, name: str = "standard input") -> Mesh:
    """Read a model of a format, a key of `FORMATS`, from a stream to its end, gzipped or not.

    Parameters
    ----------
    stream : binary file object
        Read to its end.
    format : str
        A key of `FORMATS`.
    name : str
        Name of the stream, for messages. Files that the model refers to are looked for in the current folder.

    Returns
    -------
    Mesh
        As from `read_mesh`.

    Raises
    ------
    InputError, FormatError
        As from `read_mesh`, and for a format that is not in `FORMATS`.
    """
    if format not in FORMATS:
        raise InputError(f"'{format}' is not a format, expected one of {', '.join(FORMATS)}")
    content = io.BytesIO()
    try:
        while part := stream.read(_PART):
            content.write(part)
            if content.tell() > MOST_BYTES:
                raise InputError(f"{name} is longer than {MOST_BYTES >> 30} GB, the most that is read")
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
        packed = raw.startswith(GZIP_MAGIC)
        plain, tail = unpacked(raw) if packed else (raw, b"")
        archive = _archive(plain, path)
        if packed and archive is not None:
            raise InputError(f"{path} is a gzipped zip archive, expected one that is not gzipped")
        # Files that a model in an archive refers to are not beside the archive.
        place, content = (path, plain) if archive is None else (path / archive.name, archive.content)
        document = (entry or detect_format(content, place)).parse(content, place)
        source = SourceFile(
            path=path,
            document=document,
            packed=raw if packed else None,
            plain=plain if packed else None,
            archive=archive,
            tail=tail,
        )
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
        if path.is_file() and path.stat().st_size > MOST_BYTES:
            raise InputError(f"{path} is larger than {MOST_BYTES >> 30} GB, the most that is read", file=path)
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
