"""The report of a benchmark: CSV, Markdown, pictures and a page, from rows and facts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from meshmark.errors import OutputError
from meshmark.io import Staging
from meshmark.research.benchmark.figures.aggregate import robustness
from meshmark.research.benchmark.figures.csv_files import results_csv, summary_csv
from meshmark.research.benchmark.page.drawing import has_matplotlib, legend
from meshmark.research.benchmark.page.markdown import markdown
from meshmark.research.benchmark.page.page import page
from meshmark.research.benchmark.page.plots import plots
from meshmark.research.benchmark.page.report_parts import Plot
from meshmark.research.benchmark.run.facts import Facts
from meshmark.research.benchmark.run.job import Outcome, Probe
from meshmark.research.benchmark.run.row import Row
from meshmark.research.benchmark.run.store import NAME
from meshmark.research.benchmark.sections import sections

__all__ = ["refuse_folder", "write_reports"]

_PICTURES = "plots"
_REPORTS = ("report.html", "report.md", "results.csv", "summary.csv")
# What a run puts into its folder beside its store.
_OURS = (*_REPORTS, _PICTURES, "marked", "models")


def refuse_folder(folder: Path) -> None:
    """Raise `OutputError` for a folder that is of no run, but holds files that a run would write over."""
    taken = [name for name in _OURS if (folder / name).exists()]
    if taken and not (folder / NAME).exists():
        raise OutputError(
            f"{folder / taken[0]} exists already and no run of a benchmark made it, expected another --out, or "
            "--force to replace it",
            file=folder / taken[0],
        )


def write_reports(
    rows: Sequence[Row], facts: Facts, folder: Path, probes: Mapping[Probe, Outcome] | None = None
) -> list[Path]:
    """Write the reports into a folder and return the paths of report.html, report.md, results.csv, summary.csv.

    The pictures of report.md go to the folder plots, as SVG; without matplotlib (`pip install meshmark[research]`)
    the reports have none, and say so. The same rows and facts give the same bytes. Raises `OutputError` where a
    file cannot be written.
    """
    ordered = sorted(rows, key=lambda row: row.case)
    title = f"meshmark bench {facts.suite}"
    drawn = plots(ordered) if has_matplotlib() else {}
    parts = sections(ordered, facts, drawn, probes)
    shown = [part for section in parts for part in section.parts if isinstance(part, Plot)]
    texts = {
        "report.html": page(title, parts, facts),
        "report.md": markdown(title, parts, facts.command, _PICTURES),
        "results.csv": results_csv(ordered),
        "summary.csv": summary_csv(robustness(ordered)),
    }
    drawings = {f"{_PICTURES}/{name}.svg": svg + "\n" for name, svg in _pictures(shown)}
    _write(folder, texts | drawings)
    return [folder / name for name in texts]


def _pictures(drawn: Sequence[Plot]) -> Iterator[tuple[str, str]]:
    """Yield the name and the SVG of every panel, and of a legend for each plot that has one."""
    for plot in drawn:
        for panel in plot.panels:
            yield panel.name, panel.svg
        if len(plot.legend) > 1:
            name = f"{plot.panels[0].name}-legend"
            yield name, legend(name, plot.legend)


def _write(folder: Path, texts: Mapping[str, str]) -> None:
    """Write all files of a report, or none, in place of those of an earlier start."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make the folder {folder}: {error.strerror}", file=folder) from None
    with Staging() as staging:
        for name, text in texts.items():
            staging.put(folder / name, text.encode("utf-8"), folder)
