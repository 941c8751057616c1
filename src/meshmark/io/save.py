"""From a mesh to files: patched into its document or converted, and moved into place only when complete."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from meshmark.errors import InputError, MeshmarkError, OutputError
from meshmark.io.conversion import converted
from meshmark.io.formats import FORMATS, Format, check_extension, format_of_name
from meshmark.io.gzip_data import MOST_BYTES
from meshmark.io.inside import read_inside
from meshmark.io.source import SourceFile
from meshmark.io.staging import Staging
from meshmark.mesh import Mesh

__all__ = ["WriteReport", "check_recompression", "input_files", "uncompressed", "write_mesh"]


@dataclass(frozen=True, kw_only=True)
class WriteReport:
    """What a save wrote.

    files:   the files, the model first. dropped: names of what the target format could not keep.
    decompressed: the extensions that compressed the file read and do not compress the one written.
    """

    files: tuple[Path, ...]
    dropped: tuple[str, ...] = ()
    decompressed: tuple[str, ...] = ()


def _check_is_mesh(mesh: object) -> None:
    if isinstance(mesh, Mesh):
        return
    kind = type(mesh).__name__
    if isinstance(getattr(mesh, "mesh", None), Mesh):
        raise InputError(
            f"write_mesh was given an {kind}, expected a mesh: pass its attribute, {kind.lower()}.mesh"
        )
    raise InputError(f"write_mesh was given an object of type {kind}, expected a Mesh")


def write_mesh(
    mesh: Mesh,
    path: str | Path,
    verify: Callable[[Path], None] | None = None,
    default: str | None = None,
    *,
    recompress: bool = False,
    staging: Staging | None = None,
) -> WriteReport:
    """Write a mesh to `path`: positions patched into the file it came from, or converted to a new one.

    A patched save changes nothing but positions and copies side files (materials, images) that are not there yet.
    All files are complete before any is moved into place; on failure none is left. A compressed file (glTF) is
    written uncompressed, as `WriteReport.decompressed` says, unless nothing moved.

    Parameters
    ----------
    mesh : Mesh
        The surface; `mesh.document` is the file that positions are patched into, None for a new file.
    path : str or Path
        Its extension says the format; without an extension it is that of the file read.
    verify : callable, optional
        Called with the path of the complete model before it is moved into place; raising stops the save.
    default : str, optional
        The format, a key of `FORMATS`, of a mesh made in memory where the path has no known extension.
    recompress : bool
        Compress a file that was compressed as it was.
    staging : Staging, optional
        Takes the files, to move them into place together with others. Without it that is done at once, and
        existing files are replaced.

    Returns
    -------
    WriteReport
        What the written file does not hold any more.

    Raises
    ------
    InputError
        `path` is the file read or one it refers to, has no known format or one that is not written, or cannot be
        compressed as it was.
    OutputError
        A file cannot be written.
    """
    path = Path(path)
    _check_is_mesh(mesh)
    entry = _format_for(mesh, path, default)
    document = mesh.document
    if recompress:
        check_recompression(mesh, path)
    source = document if isinstance(document, SourceFile) else None
    origin = None if source is None else source.path
    inputs = input_files(mesh)
    target = _checked_target(path, inputs)
    if document is not None:
        check_extension(path, None if source is None else source.path)
    copies: dict[str, Path] = {}
    dropped: tuple[str, ...] = ()
    decompressed: tuple[str, ...] = ()
    if document is not None and not np.array_equal(mesh.faces, document.faces):
        raise InputError(
            "the mesh has other faces than the file it came from; drop its document to save it anew"
        )
    if document is not None and document.format == entry.name:
        holder = source or SourceFile(path=path, document=document)
        files = dict(holder.patched(mesh.vertices, path.name))
        decompressed = holder.decompressed(mesh.vertices)
        if recompress:
            files, decompressed = holder.recompressed(files, path.name, decompressed), ()
        copies, dropped = _side_copies(holder, target.parent), holder.left_behind(path.name)
    else:
        files, dropped = converted(mesh, entry, path.name)
        dropped += () if source is None else source.left_behind(path.name)
    main = files.pop(path.name)
    try:
        present = _present(files, target)
        files |= {name: _side_file(source, name) for name in copies if name not in files}
        places = {target: main, **{target.parent / name: data for name, data in files.items()}}
        with ExitStack() as owned:
            stage = owned.enter_context(Staging()) if staging is None else staging
            stage.keep(*inputs)
            staged = [
                stage.put(
                    place,
                    data,
                    target.parent,
                    move=place not in present,
                    like=copies.get(os.path.relpath(place, target.parent), origin),
                )
                for place, data in places.items()
            ]
            if verify is not None:
                verify(staged[0])
        return WriteReport(files=tuple(places), dropped=dropped, decompressed=decompressed)
    except OSError as error:
        if isinstance(error, OutputError):
            raise
        raise OutputError(
            f"cannot write {error.filename or path}: {error.strerror or error}", file=path
        ) from None


def uncompressed(report: WriteReport, path: Path) -> tuple[str, ...]:
    """Return the sentence, if any, that a save to `path` wrote a compressed model uncompressed."""
    if not report.decompressed:
        return ()
    names = " and ".join(report.decompressed)
    return (f"{path.name} is written without the compression of the input ({names}), all else is kept",)


def check_recompression(mesh: Mesh, path: Path) -> None:
    """Check that a mesh can be written to `path` compressed as its file was.

    Parameters
    ----------
    mesh : Mesh
        A mesh that was read from a file.
    path : Path
        Where it would be written.

    Raises
    ------
    InputError
        It was not compressed, would be written in another format, or its compression cannot be made.
    """
    document = mesh.document
    if not isinstance(document, SourceFile) or _format_for(mesh, path, None).name != document.format:
        raise InputError(f"cannot compress {path} as its input is: it is written in another format")
    document.check_recompression()


def _format_for(mesh: Mesh, path: Path, default: str | None) -> Format:
    entry = format_of_name(path)
    own = default if mesh.document is None else mesh.document.format
    if entry is None and own is not None:
        entry = FORMATS[own]
    if entry is None:
        known = " ".join(entry.extensions[0] for entry in FORMATS.values())
        raise InputError(f"{path} has no extension of a known format, expected one of {known}, also .gz")
    return entry


def _checked_target(path: Path, inputs: Sequence[Path]) -> Path:
    # A link is followed: what it points to is replaced, not the link.
    try:
        target = Path(os.path.realpath(path))
        if target.is_dir():
            raise OutputError(f"cannot write {path}: it is an existing directory", file=path)
        if target.exists() and not target.is_file():
            raise OutputError(f"cannot write {path}: it is not an ordinary file", file=path)
        if not target.parent.is_dir():
            raise OutputError(f"cannot write {path}: the folder {target.parent} does not exist", file=path)
        for other in inputs:
            if target.exists() and other.exists() and target.samefile(other):
                raise InputError(
                    f"cannot write {path}: it is the input, or a file that the input refers to", file=path
                )
    except (OSError, ValueError) as error:
        if isinstance(error, MeshmarkError):
            raise
        raise OutputError(f"cannot write {path}: {error}", file=path) from None
    return target


def input_files(mesh: Mesh) -> tuple[Path, ...]:
    """Return the files that a mesh was read from.

    Parameters
    ----------
    mesh : Mesh
        Any mesh.

    Returns
    -------
    tuple of Path
        The model and the files that it refers to; none for a mesh made in memory.
    """
    source = mesh.document
    if not isinstance(source, SourceFile):
        return ()
    files = (source.path, *source.side_files())
    if source.format != "gltf":
        return files
    # The buffers that hold positions are no side files, but a save returns them.
    own = source.document.patched(source.vertices, source.path.name.removesuffix(".gz"))
    return (*files, *(source.path.parent / name for name in own))


def _present(files: Mapping[str, bytes], target: Path) -> set[Path]:
    """Return the second files that are there already with this very content.

    Another model may use an existing file of another content: it is replaced only where it is OUT's, by its name or
    because OUT is replaced too. Raises `InputError` for any other.
    """
    present = set()
    for name, data in files.items():
        place = target.parent / name
        if place.is_file() and place.stat().st_size == len(data) and place.read_bytes() == data:
            present.add(place)
        elif place.exists() and not (target.exists() or name.startswith(target.name.split(".")[0])):
            raise InputError(
                f"cannot write {target.name} here: it would replace {name}, which another model may need; "
                "choose another folder"
            )
    return present


def _side_file(source: SourceFile | None, name: str) -> bytes:
    """Return the bytes of a file beside a model, opened without following links."""
    if source is None:
        raise InputError(f"{name} belongs to no file that was read")
    return read_inside(source.path.parent, name, MOST_BYTES)


def _side_copies(source: SourceFile, folder: Path) -> dict[str, Path]:
    home = source.path.parent
    if not home.is_dir() or folder.samefile(home):
        return {}
    names = {os.path.relpath(origin, home): origin for origin in source.side_files()}
    return {name: origin for name, origin in names.items() if not (folder / name).exists()}
