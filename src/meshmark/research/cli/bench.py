"""`meshmark bench`: measure schemes on models under attacks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from meshmark.cli.options import AsJson, Force
from meshmark.cli.output import answer, described, plural, say
from meshmark.cli.progress import counted
from meshmark.errors import InputError

if TYPE_CHECKING:
    from meshmark.research.benchmark.run.run import Finished

__all__ = ["bench"]


def bench(
    suite: Annotated[
        str, typer.Argument(metavar="SUITE", help="smoke, paper, robust, ownership, security or speed.")
    ],
    data: Annotated[
        Path | None,
        typer.Option(
            "--data", metavar="DIR", help="Models, at any depth, also .xz; without it, three that come along."
        ),
    ] = None,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for results and reports.")] = Path(
        "bench-out"
    ),
    schemes: Annotated[
        str | None,
        typer.Option(
            metavar="A,B",
            help="Schemes, also of other packages or a file .py; all; without it, those of the suite.",
        ),
    ] = None,
    limit: Annotated[
        int | None, typer.Option(metavar="N", help="Use N models only, spread over file sizes.")
    ] = None,
    seed: Annotated[
        int, typer.Option(metavar="N", help="All keys, payloads and attacks follow from it.")
    ] = 0,
    workers: Annotated[
        int | None, typer.Option(metavar="N", help="Processes; without it, one on each core.")
    ] = None,
    time_limit: Annotated[
        float, typer.Option(metavar="SECONDS", help="Longest time for one marking or one attack and reading.")
    ] = 600.0,
    hours: Annotated[
        float | None,
        typer.Option(metavar="H", help="Begin no further model after so long; go on another time."),
    ] = None,
    force: Force = False,
    as_json: AsJson = False,
) -> int:
    """Measure schemes on models under attacks.

    Results go to DIR/results.sqlite as they come. The same command goes on where an earlier one was cut off, and
    repeats nothing. At the end tables and plots are written to DIR. What fails is a row, not an end.
    A DIR without results, but with files of the names to be written, is refused without --force.
    """
    from meshmark.research.benchmark.reports import refuse_folder
    from meshmark.research.benchmark.run.run import Plan, run

    names = None if schemes is None else tuple(name.strip() for name in schemes.split(",") if name.strip())
    if names == ():
        raise InputError("--schemes names no scheme, expected at least one")
    plan = Plan(
        suite=suite,
        data=data,
        out=out,
        schemes=names,
        limit=limit,
        seed=seed,
        workers=workers,
        time_limit=time_limit,
        hours=hours,
    )
    if not force:
        refuse_folder(out)
    try:
        with counted("cases") as progress:
            finished = run(plan, progress)
    except KeyboardInterrupt:
        say(f"meshmark: what is done is kept in {out}; the same command goes on from there")
        raise
    if finished.resumed:
        say(f"meshmark: {plural(finished.resumed, 'row')} had been done before")
    if finished.left:
        say(f"meshmark: {plural(finished.left, 'case')} left; the same command goes on with them")
    reports = _reports(finished, out)
    outputs = {path.name: path for path in reports}
    answer(_words(finished, reports), described(_fields(finished, reports), data, outputs), as_json)
    return 0


def _reports(finished: Finished, out: Path) -> list[Path]:
    from meshmark.research.benchmark.reports import write_reports

    return write_reports(finished.rows, finished.facts, out, finished.probes)


def _fields(finished: Finished, reports: list[Path]) -> dict[str, Any]:
    from meshmark.research.benchmark.figures.summary import summary

    return {
        "facts": finished.facts.to_dict(),
        "rows": len(finished.rows),
        "resumed": finished.resumed,
        "left": finished.left,
        "reports": [str(path) for path in reports],
        "summary": [line.to_dict() for line in summary(finished.rows)],
    }


def _words(finished: Finished, reports: list[Path]) -> str:
    from meshmark.research.benchmark.figures.summary import as_table, summary

    lines = as_table(summary(finished.rows))
    return "\n".join([*lines, "", *(f"Written: {path}" for path in reports)])
