"""The tables of a report, from aggregated figures."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import TypeVar

from meshmark.research.benchmark.figures.aggregate import ALL, Alarms, Robustness, groups
from meshmark.research.benchmark.figures.distortion import MEASURES, Distortion
from meshmark.research.benchmark.figures.intervals import Estimate
from meshmark.research.benchmark.figures.labels import label, ordered
from meshmark.research.benchmark.figures.speed import Speed
from meshmark.research.benchmark.page.report_parts import NOTHING, Cell, Table, estimate, number, percent
from meshmark.research.benchmark.run.row import Row

__all__ = [
    "MEASURE_LABELS",
    "alarm_table",
    "attack_tables",
    "distortion_table",
    "scheme_tables",
    "size_tables",
    "speed_table",
    "trouble_table",
]

MEASURE_LABELS = {
    "rms_over_diagonal": "RMS",
    "max_over_diagonal": "largest",
    "mrms_over_diagonal": "MRMS",
    "hausdorff_over_diagonal": "Hausdorff",
    "msdm2": "MSDM2",
    "normal_deviation_deg": "normals",
    "psnr_db": "PSNR",
    "paper_psnr_db": "paper's PSNR",
}
_EXAMPLES = 3
T = TypeVar("T")
K = TypeVar("K", bound=Hashable)


def attack_tables(figures: Sequence[Robustness], split: str) -> list[Table]:
    """Return for each scheme and budget a table of all attacks, over all sizes of a split."""
    tables = []
    for (scheme, budget), part in _by_mark(figures, split, ALL).items():
        rows = tuple(_attack_row(item) for item in part)
        columns = (
            *("attack", "models", "mark found", "id exact", "bit errors"),
            *("raw bit errors", "correlation", "refused", "failed"),
        )
        tables.append(Table(title=f"{scheme}, {budget}: all sizes", columns=columns, rows=rows))
    return tables


def _attack_row(item: Robustness) -> tuple[Cell, ...]:
    trials = f"{item.trials} trials" if item.trials != item.models else ""
    return (
        Cell(text=label(item.attack)),
        Cell(text=str(item.models), small=trials),
        estimate(item.present),
        estimate(item.recovered),
        estimate(item.ber, good="low"),
        estimate(item.raw_ber, good=""),
        Cell(
            text=NOTHING
            if item.correlation is None
            else f"{round(item.correlation, 2) + 0.0:.2f}".replace("-", "−")
        ),
        _count(item.refused),
        _count(item.broken),
    )


def size_tables(figures: Sequence[Robustness], split: str, sizes: Sequence[str]) -> list[Table]:
    """Return for each scheme and budget, and for found, exact and bit errors, attacks against size classes."""
    tables = []
    chosen = [item for item in figures if item.split == split]
    for (scheme, budget), part in _by_mark(chosen, split, None).items():
        at = {(item.attack, item.size_class): item for item in part}
        attacks = ordered({item.attack for item in part})
        for title, cell in _BY_SIZE.items():
            rows = tuple(
                (Cell(text=label(attack)), *(cell(at.get((attack, size))) for size in (ALL, *sizes)))
                for attack in attacks
            )
            tables.append(
                Table(
                    title=f"{scheme}, {budget}: {title} by size",
                    columns=("attack", ALL, *sizes),
                    rows=rows,
                    folded=True,
                )
            )
    return tables


def scheme_tables(figures: Sequence[Robustness], split: str) -> list[Table]:
    """Return for each budget and size class a table of attacks against schemes; none for a single scheme."""
    schemes = sorted({item.scheme for item in figures})
    if len(schemes) < 2:
        return []
    tables = []
    chosen = [item for item in figures if item.split == split]
    for (budget, size), part in groups_of(chosen, lambda item: (item.budget, item.size_class)).items():
        at = {(item.attack, item.scheme): item for item in part}
        for title, cell in _BY_SIZE.items():
            rows = tuple(
                (Cell(text=label(attack)), *(cell(at.get((attack, scheme))) for scheme in schemes))
                for attack in ordered({item.attack for item in part})
            )
            named = f"{budget}, {size} points" if size != ALL else f"{budget}, all sizes"
            tables.append(
                Table(title=f"{title}: {named}", columns=("attack", *schemes), rows=rows, folded=size != ALL)
            )
    return sorted(tables, key=lambda table: table.folded)


def alarm_table(figures: Sequence[Alarms]) -> Table:
    """Return what was found where there was nothing to find."""
    columns = (
        *("scheme", "what was read", "points", "trials", "found", "rate at most"),
        *("bit errors", "smallest p", "not read"),
    )
    rows = tuple(
        (
            Cell(text=item.scheme),
            Cell(text={"unmarked": "unmarked model", "forged": "copied mark"}.get(item.trial, item.trial)),
            Cell(text=item.size_class),
            Cell(text=str(item.trials)),
            Cell(
                text=str(item.found),
                heat=None if not item.trials else 1.0 - min(1.0, item.found / item.trials),
            ),
            Cell(text=percent(item.limit, 1 if item.limit > 0.01 else 3)),
            _chance(item.ber),
            Cell(text=_power(item.least)),
            _count(item.not_read),
        )
        for item in figures
    )
    note = (
        "“rate at most” is exceeded with at most 5 % confidence (Clopper-Pearson, one-sided). Wrong keys should "
        "read about 50 % of the bits wrong. “smallest p” is the smallest false-positive bound that was claimed: "
        "among n trials one of about 1/n is expected."
    )
    return Table(title="Finding what is not there", columns=columns, rows=rows, note=note)


def distortion_table(figures: Sequence[Distortion]) -> Table:
    """Return mean and worst of each measure, by scheme, budget and size class."""
    at = {(d.scheme, d.budget, d.size_class, d.measure): d for d in figures}
    keys = list(dict.fromkeys((d.scheme, d.budget, d.size_class) for d in figures))
    shown = [name for name in MEASURES if any(d.measure == name for d in figures)]
    rows = tuple(
        (
            *(Cell(text=text) for text in key),
            Cell(text=str(max(at[(*key, name)].count for name in shown if (*key, name) in at))),
            *(_measure(name, at.get((*key, name))) for name in shown),
        )
        for key in keys
    )
    columns = ("scheme", "budget", "points", "models", *(MEASURE_LABELS[name] for name in shown))
    note = (
        "Mean over models and the worst one. Lengths in % of the bounding box's diagonal, angles in degrees."
    )
    return Table(title="Distortion of the marked models", columns=columns, rows=rows, note=note)


def speed_table(figures: Sequence[Speed]) -> Table:
    """Return median times, growth and memory, by scheme, budget and size class."""
    columns = (
        *("scheme", "budget", "points", "models", "embed s", "extract s", "read + write s"),
        *("vertices/s", "peak MB", "growth"),
    )
    rows = tuple(
        (
            Cell(text=item.scheme),
            Cell(text=item.budget),
            Cell(text=item.size_class, small=f"median {item.points:,.0f}"),
            Cell(text=str(item.models)),
            *(Cell(text=number(value)) for value in (item.embed, item.extract, item.file)),
            Cell(text=number(item.vertices_per_second)),
            Cell(text=number(item.peak_mb)),
            Cell(text=_growth(item)),
        )
        for item in figures
    )
    note = (
        "Medians over models, wall-clock, other work may run beside it. “growth” is g of seconds ~ points^g for "
        "embedding / extraction: 1 is twice the time for twice the points. “vertices/s” is of extraction."
    )
    return Table(title="Time and memory", columns=columns, rows=rows, note=note)


def trouble_table(rows: Sequence[Row]) -> Table:
    """Return every kind of case that was not measured, with its sentence, how often, and models."""
    trouble = [row for row in rows if row.status != "ok"]
    kinds = groups(trouble, "status", "scheme", "note")
    lines = []
    for (status, scheme, note), part in sorted(kinds.items(), key=lambda kind: (kind[0][0], -len(kind[1]))):
        models = sorted({row.case.model for row in part})
        attacks = ordered({row.case.attack for row in part})
        lines.append(
            (
                Cell(text=status),
                Cell(text=scheme),
                Cell(text=str(len(part))),
                Cell(text=note or NOTHING),
                Cell(text=_some(models)),
                Cell(text=_some([label(attack) for attack in attacks])),
            )
        )
    columns = ("outcome", "scheme", "cases", "sentence", "models", "attacks")
    return Table(title="Refused and failed cases", columns=columns, rows=tuple(lines))


def groups_of(items: Sequence[T], key: Callable[[T], K]) -> dict[K, list[T]]:
    """Return items by a key, in the order of their first appearance."""
    found: dict[K, list[T]] = {}
    for item in items:
        found.setdefault(key(item), []).append(item)
    return found


def _by_mark(
    figures: Sequence[Robustness], split: str, size: str | None
) -> dict[tuple[str, str], list[Robustness]]:
    chosen = [f for f in figures if f.split == split and size in (None, f.size_class)]
    return groups_of(chosen, lambda item: (item.scheme, item.budget))


def _rate_cell(value: Estimate | None, item: Robustness) -> Cell:
    cell = estimate(value)
    return Cell(text=cell.text, small=f"{cell.small}, n {item.models}" if value else "", heat=cell.heat)


def _ber_cell(item: Robustness | None) -> Cell:
    if item is None or item.ber is None:
        return Cell(text=NOTHING)
    cell = estimate(item.ber, good="low")
    return Cell(text=cell.text, small=f"{cell.small}, n {item.ber.count}", heat=cell.heat)


_BY_SIZE: dict[str, Callable[[Robustness | None], Cell]] = {
    "id exact": lambda item: Cell(text=NOTHING) if item is None else _rate_cell(item.recovered, item),
    "mark found": lambda item: Cell(text=NOTHING) if item is None else _rate_cell(item.present, item),
    "bit errors": _ber_cell,
}


def _chance(ber: Estimate | None) -> Cell:
    """Return a bit error rate that should be a half."""
    return estimate(ber, good="")


def _measure(name: str, item: Distortion | None) -> Cell:
    if item is None:
        return Cell(text=NOTHING)
    share = name.endswith("_over_diagonal")
    mean, worst = (f"{100 * v:.3g} %" if share else f"{v:.3g}" for v in (item.mean, item.worst))
    return Cell(text=mean, small=f"worst {worst}")


def _growth(item: Speed) -> str:
    parts = (item.embed_growth, item.extract_growth)
    return NOTHING if parts == (None, None) else " / ".join(number(value, 2) for value in parts)


def _power(exponent: float | None) -> str:
    if exponent is None:
        return NOTHING
    return "1" if exponent == 0.0 else f"10^{exponent:.1f}".replace("-", "−")


def _count(value: int) -> Cell:
    return Cell(text=str(value) if value else NOTHING)


def _some(names: Sequence[str]) -> str:
    more = len(names) - _EXAMPLES
    return ", ".join(names[:_EXAMPLES]) + (f" and {more} more" if more > 0 else "")
