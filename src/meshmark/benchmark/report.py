"""The report of a benchmark: CSV, Markdown, pictures and a page, from rows and facts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from meshmark.benchmark.aggregate import robustness
from meshmark.benchmark.csv_files import results_csv, summary_csv
from meshmark.benchmark.facts import Facts
from meshmark.benchmark.markdown import markdown
from meshmark.benchmark.row import Row
from meshmark.benchmark.sections import sections
from meshmark.errors import OutputError

__all__ = ["write_reports"]


def write_reports(rows: Sequence[Row], facts: Facts, folder: Path) -> list[Path]:
    """Write results.csv, summary.csv and report.md into a folder and return their paths.

    The same rows and facts give the same bytes. Raises `OutputError` where a file cannot be written.
    """
    ordered = sorted(rows, key=lambda row: row.case)
    title = f"meshmark bench {facts.suite}"
    texts = {
        "results.csv": results_csv(ordered),
        "summary.csv": summary_csv(robustness(ordered)),
        "report.md": markdown(title, sections(ordered, facts, {}), facts.command, "plots"),
    }
    return [_write(folder / name, text) for name, text in texts.items()]


def _write(path: Path, text: str) -> Path:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from None
    return path
