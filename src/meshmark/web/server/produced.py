"""What a job made: the files that can be downloaded, and its answer without the places of files on the server."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from meshmark.web.server.orders import OUT
from meshmark.web.server.web_job import Download

__all__ = ["downloads_of", "own_names", "view_of"]

FOLDERS = ("in", "out", "certificate", "original")
"""Folders within that of a job."""
_NAMED_VIEW = re.compile(r'\bdata-view="([\w-]+)"')


def own_names(value: Any, homes: Sequence[Path]) -> Any:
    """Return an answer, or a sentence, in which files are called as in the upload; keys by their names alone.

    homes: the folders of the job and of the keys, whose places are nobody's business.
    """
    if isinstance(value, str):
        shown = value
        for home in homes:
            shown = shown.replace(f"{home}/", "").replace(f"{home.resolve()}/", "")
        for folder in FOLDERS:
            shown = shown.removeprefix(f"{folder}/").replace(f" {folder}/", " ")
        return shown
    if isinstance(value, Mapping):
        return {name: own_names(entry, homes) for name, entry in value.items()}
    if isinstance(value, list):
        return [own_names(entry, homes) for entry in value]
    return value


def downloads_of(folder: Path, answer: Mapping[str, Any]) -> Iterator[Download]:
    """Yield the files that an answer names; a model of several files comes as one zip archive.

    folder: of the job, to which the names in the answer are relative.
    """
    beside = [Path(name) for name in answer.get("side_files", ())]
    for kind, name in answer.get("outputs", {}).items():
        path = folder / name
        if kind == "model" and beside:
            path = _archive(path, [folder / each for each in beside], folder / OUT)
        yield Download(kind=kind, name=path.name, path=path, bytes=path.stat().st_size)


def view_of(downloads: Iterable[Download], folder: Path) -> Path | None:
    """Write what the interactive view of a report shows to a file of its own; None without such a report."""
    for report in (each.path for each in downloads if each.kind == "report"):
        page = report.read_text(encoding="utf-8")
        named = _NAMED_VIEW.search(page)
        if named is None:
            continue
        held = re.search(rf'<script[^>]*\bid="{re.escape(named[1])}"[^>]*>(.*?)</script>', page, re.DOTALL)
        if held is not None:
            path = folder / "view.json"
            path.write_text(held[1], encoding="utf-8")
            return path
    return None


def _archive(model: Path, others: list[Path], home: Path) -> Path:
    """Write a zip archive of a model and the files beside it, which keep their places."""
    path = model.with_name(f"{model.stem}.zip")
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for each in (model, *others):
            archive.write(each, each.resolve().relative_to(home.resolve()).as_posix())
    return path
