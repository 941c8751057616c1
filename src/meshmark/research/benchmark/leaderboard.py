"""The leaderboard: every scheme under every attack, from a `results.csv`, and where NCDG-LV does not lead.

python -m meshmark.research.benchmark.leaderboard RESULTS.csv [PAGE.md]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from meshmark.errors import InputError
from meshmark.research import SCHEMES
from meshmark.research.benchmark.figures.aggregate import ALL, alarms, main_split, robustness
from meshmark.research.benchmark.figures.csv_files import read_results
from meshmark.research.benchmark.figures.distortion import distortions
from meshmark.research.benchmark.figures.labels import NOTHING as UNTOUCHED
from meshmark.research.benchmark.figures.labels import label, ordered
from meshmark.research.benchmark.figures.speed import speeds
from meshmark.research.benchmark.page.markdown import markdown
from meshmark.research.benchmark.page.report_parts import NOTHING, Cell, Section, Table, number, percent
from meshmark.research.benchmark.paper.compared import standing
from meshmark.research.benchmark.paper.measured import OWN, Group, Measured
from meshmark.research.benchmark.run.row import Row

__all__ = ["leaderboard", "main"]


def leaderboard(rows: Sequence[Row], command: str = "") -> str:
    """Return the page as Markdown; raises `InputError` for rows without a marked trial."""
    if not any(row.case.trial == "marked" for row in rows):
        raise InputError("the results hold no marked model, expected those of a suite such as robust")
    split = main_split(rows)
    chosen = [row for row in rows if split in (ALL, row.split)]
    budgets = [
        name for name in ("standard", "subtle", "strong") if any(r.case.budget == name for r in chosen)
    ]
    sections = [_summary(chosen, split)]
    for budget in budgets:
        part = [row for row in chosen if row.case.budget == budget]
        by_attack, behind = _attacks(part)
        words = (_told(behind, len(by_attack.rows)),) if behind is not None else ()
        title = f"Strength {budget}"
        sections.append(Section(name=budget, title=title, words=words, parts=(_schemes(part), by_attack)))
    return markdown("Leaderboard", sections, command, "")


def main(arguments: Sequence[str]) -> int:
    """Write the page of a file of results, to standard output where no page is named."""
    if not 1 <= len(arguments) <= 2:
        print(__doc__, file=sys.stderr)
        return 2
    source = Path(arguments[0])
    command = " ".join(["python -m meshmark.research.benchmark.leaderboard", source.name])
    try:
        page = leaderboard(read_results(source.read_text(encoding="utf-8")), command)
        if len(arguments) == 1:
            print(page, end="")
        else:
            Path(arguments[1]).write_text(page, encoding="utf-8")
    except (OSError, InputError) as error:
        print(f"leaderboard: {error}", file=sys.stderr)
        return 2
    except KeyError as error:
        print(
            f"leaderboard: {source} is no results.csv of this version's benchmark: it has no column {error}",
            file=sys.stderr,
        )
        return 2
    except UnicodeDecodeError:
        print(f"leaderboard: {source} is no results.csv of a benchmark: it is no text", file=sys.stderr)
        return 2
    return 0


def _summary(rows: Sequence[Row], split: str) -> Section:
    models = len({row.case.model for row in rows})
    schemes = len({row.case.scheme for row in rows})
    suites = ", ".join(sorted({row.case.suite for row in rows}))
    seeds = ", ".join(sorted({str(row.case.seed) for row in rows}))
    where = " of the test split" if split == "test" else ""
    words = (
        f"Schemes: {schemes}; models: {models}{where}; suite {suites}, seed {seeds}. All schemes carry their "
        "payload within the same budget of distortion: RMS vertex displacement of at most 0.08 % of the "
        "diagonal at strength standard, 0.02 % at subtle. An id counts as exact when the scheme says that "
        "a mark is there and every bit is right; a refused or failed model is a miss. Bit errors are of "
        "the models read: 50 % is guessing.",
        "“Informed” schemes are given the original. Schemes of others are our reconstructions wherever "
        "their source leaves something open; the source of each says what. How to add yours: "
        "docs/your-scheme.md.",
    )
    return Section(name="summary", title="What is compared", words=words)


def _schemes(rows: Sequence[Row]) -> Table:
    figures = [item for item in robustness(rows) if (item.split, item.size_class) == (ALL, ALL)]
    found = [item for item in alarms(rows) if item.size_class == ALL]
    changes = {
        d.scheme: d for d in distortions(rows) if (d.size_class, d.measure) == (ALL, "rms_over_diagonal")
    }
    times = {item.scheme: item for item in speeds(rows) if item.size_class == ALL}
    lines = []
    for name in sorted({item.scheme for item in figures}):
        own = [item for item in figures if item.scheme == name]
        attacked = [item for item in own if item.attack != UNTOUCHED]
        clean = [item for item in own if item.attack == UNTOUCHED]
        exact = _mean([item.recovered.value for item in attacked])
        errors = _mean([item.ber.value for item in attacked if item.ber])
        mine = [item for item in found if item.scheme == name]
        rms, time = changes.get(name), times.get(name)
        cells = (
            Cell(text=name, small=_kind(name)),
            Cell(text=percent(exact), heat=exact),
            Cell(text=percent(errors)),
            Cell(text=percent(clean[0].recovered.value) if clean else NOTHING),
            Cell(text=f"{max(item.refused for item in own)} of {max(item.models for item in own)}"),
            Cell(text=f"{sum(a.found for a in mine)} of {sum(a.trials for a in mine)}"),
            Cell(text=f"{100 * rms.mean:.3g} %" if rms else NOTHING),
            Cell(text=number(time.embed if time else None)),
            Cell(text=number(time.extract if time else None)),
        )
        lines.append((-(exact or 0.0), errors if errors is not None else 1.0, cells))
    columns = (
        *("scheme", "attacked: id exact", "attacked: bit errors", "untouched: id exact", "refused"),
        *("false alarms", "RMS change", "embed s", "extract s"),
    )
    note = "Mean over attacks, each alike; ordered by exact ids. Times are medians."
    return Table(
        title="Schemes",
        columns=columns,
        rows=tuple(cells for *_, cells in sorted(lines, key=lambda line: line[:2])),
        note=note,
    )


def _attacks(rows: Sequence[Row]) -> tuple[Table, list[tuple[str, bool]] | None]:
    """Return the table of attacks, and those in which NCDG-LV is behind; None where it was not measured."""
    measured = Measured(rows, {})
    everything = Group(label=ALL, models=frozenset(row.case.model for row in measured.rows))
    at = {(f.scheme, f.attack): f for f in robustness(rows) if (f.split, f.size_class) == (ALL, ALL)}
    own = OWN in measured.schemes and len(measured.schemes) > 1
    lines, behind = [], []
    for attack in ordered({attack for _, attack in at}):
        cells = [Cell(text=label(attack))]
        for name in measured.schemes:
            figure = at.get((name, attack))
            if figure is None:
                cells.append(Cell(text=NOTHING))
                continue
            errors = NOTHING if figure.ber is None else percent(figure.ber.value)
            cells.append(
                Cell(
                    text=percent(figure.recovered.value, 0),
                    small=f"{errors} bits",
                    heat=figure.recovered.value,
                )
            )
        if own:
            values = {
                name: measured.values(name, (attack,), lambda row: row.ber) for name in measured.schemes
            }
            lost = measured.values(
                OWN, (attack,), lambda row: None if row.present is None else float(not row.present)
            )
            said = standing(values, everything, "%", lost)
            behind += [(label(attack), said.clearly)] if said.behind else []
            cells.append(Cell(text=said.words))
        lines.append(tuple(cells))
    columns = ("attack", *measured.schemes, *(("NCDG-LV, blind",) if own else ()))
    note = (
        "Share of models with an exact id, and bit errors. The last column compares bit errors on the "
        "models that both could mark."
    )
    return Table(title="Attacks", columns=columns, rows=tuple(lines), note=note), behind if own else None


def _told(behind: Sequence[tuple[str, bool]], count: int) -> str:
    clear = [attack for attack, clearly in behind if clearly]
    others = [attack for attack, clearly in behind if not clearly]
    if not behind:
        return f"NCDG-LV leads or is level in all {count} rows."
    parts = [f"It is behind by more than chance: {', '.join(clear)}."] if clear else []
    parts += [f"Behind within chance: {', '.join(others)}."] if others else []
    return (
        f"NCDG-LV does not lead in {len(behind)} of {count} rows; the last column says why. {' '.join(parts)}"
    )


def _kind(name: str) -> str:
    scheme = SCHEMES.get(name) if not name.endswith(".py") else None
    return "" if scheme is None else "blind" if scheme.blind else "informed"


def _mean(values: Sequence[float]) -> float | None:
    return sum(values) / len(values) if values else None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
