"""The first part of a report: what was measured and what came out, in words, and one table at a glance."""

from __future__ import annotations

from collections.abc import Sequence

from meshmark.benchmark.aggregate import (
    ALL,
    Alarms,
    Robustness,
    alarms,
    groups,
    main_split,
    marked,
    robustness,
)
from meshmark.benchmark.distortion import distortions
from meshmark.benchmark.facts import Facts
from meshmark.benchmark.intervals import Estimate, rate_by_model, upper_limit
from meshmark.benchmark.labels import NOTHING as UNTOUCHED
from meshmark.benchmark.labels import label
from meshmark.benchmark.layout import Cell, Section, Table, estimate, number, percent
from meshmark.benchmark.row import Row
from meshmark.benchmark.speed import speeds

__all__ = ["overview"]


def overview(rows: Sequence[Row], facts: Facts, *, pictures: bool = True) -> Section:
    """Return the summary; it also holds for no rows at all."""
    if not rows:
        return Section("summary", "Summary", ("No case has been measured yet.",))
    split = main_split(rows)
    chosen = [row for row in rows if split in (ALL, row.split)]
    figures = [item for item in robustness(chosen) if (item.split, item.size_class) == (ALL, ALL)]
    words = [_measured(chosen, rows, facts, split), *_results(figures), *_false_alarms(alarms(rows))]
    if not pictures:
        words.append("This report has no plots: they need matplotlib (pip install meshmark[bench]).")
    table = _glance(chosen, figures, alarms(rows))
    return Section("summary", "Summary", tuple(words), (table,) if table.rows else ())


def _measured(chosen: Sequence[Row], rows: Sequence[Row], facts: Facts, split: str) -> str:
    models = len({row.case.model for row in chosen})
    attacks = len({row.case.attack for row in marked(chosen)} - {UNTOUCHED})
    schemes = sorted({row.case.scheme for row in rows})
    where = " of the test split" if split == "test" else ""
    return (
        f"A watermark hides an id in the shape of a 3D model. Here {_listed(schemes)} marked "
        f"{_counted(models, 'model')}{where}; every marked model was then changed in {_counted(attacks, 'way')}, "
        f"as happens by editing, by exporting or on purpose, and the id was read back. The suite “{facts.suite}” "
        f"has {len(rows):,} cases, of which {sum(row.status == 'ok' for row in rows):,} could be measured."
    )


def _results(figures: Sequence[Robustness]) -> list[str]:
    """Return a sentence for each scheme and budget: untouched, all attacks, the worst attack."""
    sentences = []
    for (scheme, budget), part in _by_mark(figures).items():
        attacked = [item for item in part if item.attack != UNTOUCHED]
        clean = [item for item in part if item.attack == UNTOUCHED]
        said = [f"from {_with_interval(clean[0].recovered)} of the untouched models"] if clean else []
        if attacked:
            share = sum(i.recovered.value * i.trials for i in attacked) / sum(i.trials for i in attacked)
            said.append(f"after {percent(share)} of the attacks")
        if not said:
            continue
        text = f"{scheme} at {budget} strength gives the exact id back {' and '.join(said)}"
        worst = min(attacked, key=lambda item: item.recovered.value, default=None)
        if worst is not None:
            spared = all(item.recovered.value == worst.recovered.value for item in attacked)
            hardest = f"; hardest is {label(worst.attack)} ({percent(worst.recovered.value)})"
            text += "" if spared else hardest
        sentences.append(text + ".")
    return sentences


def _false_alarms(figures: Sequence[Alarms]) -> list[str]:
    sentences = []
    schemes = sorted({item.scheme for item in figures})
    for scheme in schemes:
        part = [a for a in figures if (a.scheme, a.size_class) == (scheme, ALL) and a.trial != "forged"]
        trials, found = sum(a.trials for a in part), sum(a.found for a in part)
        if trials:
            times = "never" if not found else "once" if found == 1 else f"{found:,} times"
            sentences.append(
                f"In {_counted(trials, 'trial')} with nothing to find, {scheme} found a mark {times}: the true "
                f"rate is at most {percent(upper_limit(found, trials))} with 95 % confidence."
            )
    return sentences


def _glance(chosen: Sequence[Row], figures: Sequence[Robustness], found: Sequence[Alarms]) -> Table:
    changes = {(d.scheme, d.budget, d.measure): d for d in distortions(chosen) if d.size_class == ALL}
    times = {(s.scheme, s.budget): s for s in speeds(chosen) if s.size_class == ALL}
    attacked = [row for row in marked(chosen) if row.case.attack != UNTOUCHED]
    pooled = groups(attacked, "scheme", "budget")
    rows = []
    for (scheme, budget), part in _by_mark(figures).items():
        clean = next((item.recovered for item in part if item.attack == UNTOUCHED), None)
        rms, speed = changes.get((scheme, budget, "rms_over_diagonal")), times.get((scheme, budget))
        mine = [a for a in found if (a.scheme, a.size_class) == (scheme, ALL) and a.trial != "forged"]
        rows.append(
            (
                Cell(scheme),
                Cell(budget),
                Cell(str(max(item.models for item in part))),
                Cell(str(max((item.refused for item in part), default=0))),
                estimate(clean),
                estimate(_pooled(pooled.get((scheme, budget), []), "present")),
                estimate(_pooled(pooled.get((scheme, budget), []), "recovered")),
                Cell(f"{sum(a.found for a in mine)} of {sum(a.trials for a in mine)}"),
                Cell(f"{100 * rms.mean:.3g} %", f"worst {100 * rms.worst:.3g} %") if rms else Cell("–"),
                Cell(number(speed.embed if speed else None)),
                Cell(number(speed.extract if speed else None)),
            )
        )
    columns = (
        *("scheme", "budget", "models", "refused", "untouched: id exact", "attacked: mark found"),
        *("attacked: id exact", "false alarms", "RMS change", "embed s", "extract s"),
    )
    note = "“Attacked” pools all attacks alike; intervals count models, not trials. Times are medians."
    return Table("At a glance", columns, tuple(rows), note)


def _pooled(rows: Sequence[Row], field: str) -> Estimate | None:
    hits = [row.status == "ok" and bool(getattr(row, field)) for row in rows]
    return rate_by_model(hits, [row.case.model for row in rows])


def _by_mark(figures: Sequence[Robustness]) -> dict[tuple[str, str], list[Robustness]]:
    found: dict[tuple[str, str], list[Robustness]] = {}
    for item in figures:
        found.setdefault((item.scheme, item.budget), []).append(item)
    return found


def _with_interval(value: Estimate) -> str:
    return f"{percent(value.value)} (95 % interval {percent(value.low, 0)[:-2]}–{percent(value.high, 0)})"


def _counted(count: int, name: str) -> str:
    return f"{count:,} {name}" + ("" if count == 1 else "s")


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
