"""The classes of the models: from `labels.csv`, or from the Princeton Shape Benchmark's files of classes."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path, PurePosixPath

from meshmark.research.benchmark.paper.published_claims import CLASSES

__all__ = ["classes_of"]

LABELS = "labels.csv"


def classes_of(data: Path, models: Sequence[str]) -> dict[str, str]:
    """Return the class, one of the paper's ten, of each model that has one; nothing where the folder tells none.

    labels.csv (columns name and paper_class) or files *.cla lie in the folder of models, anywhere below it, or in
    the folder above it. Of a .cla file every class counts whose name, or whose parent's, ends in the paper's word.
    """
    known: dict[str, str] = {}
    for path in _files(data, LABELS):
        with path.open(encoding="utf-8", newline="") as file:
            known |= {
                line["name"]: line["paper_class"] for line in csv.DictReader(file) if line["paper_class"]
            }
    for path in _files(data, "*.cla"):
        known |= dict(_classified(path.read_text(encoding="utf-8", errors="replace")))
    names = {model: PurePosixPath(model).name.split(".")[0] for model in models}
    return {model: known[name] for model, name in names.items() if known.get(name) in CLASSES}


def _files(data: Path, pattern: str) -> list[Path]:
    if not data.is_dir():
        return []
    return sorted({*data.parent.glob(pattern), *data.rglob(pattern)})


def _classified(text: str) -> Iterator[tuple[str, str]]:
    """Yield (model, class) of a file: "PSB 1", two counts, blocks of "name parent count" and that many numbers."""
    words = iter(text.split())
    if next(words, "") != "PSB":
        return
    for _ in range(3):
        next(words, "")
    parents: dict[str, str] = {}
    for name in words:
        parents[name] = next(words, "")
        count = next(words, "")
        numbers = [next(words, "") for _ in range(int(count) if count.isdigit() else 0)]
        own = next((_word(each) for each in _line(name, parents) if _word(each)), "")
        if own:
            yield from ((f"m{number}", own) for number in numbers)


def _line(name: str, parents: dict[str, str]) -> Iterator[str]:
    """Yield a class and those above it."""
    seen: set[str] = set()
    while name and name not in seen:
        yield name
        seen.add(name)
        name = parents.get(name, "")


def _word(name: str) -> str:
    return next((word for word in CLASSES if name.replace("-", "_").split("_")[-1] == word), "")
