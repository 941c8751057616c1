"""The first part of a report: what was measured and what came out, in words, and one table at a glance."""

from __future__ import annotations

from collections.abc import Sequence

from meshmark.research.benchmark.figures.aggregate import (
    ALL,
    Alarms,
    Robustness,
    alarms,
    groups,
    main_split,
    marked,
    robustness,
)
from meshmark.research.benchmark.figures.distortion import distortions
from meshmark.research.benchmark.figures.intervals import Estimate, rate_by_model, upper_limit
from meshmark.research.benchmark.figures.labels import NOTHING as UNTOUCHED
from meshmark.research.benchmark.figures.labels import label
from meshmark.research.benchmark.figures.speed import speeds
from meshmark.research.benchmark.page.report_parts import Cell, Section, Table, estimate, number, percent
from meshmark.research.benchmark.run.facts import Facts
from meshmark.research.benchmark.run.row import Row

__all__ = ["overview"]

_FEW = 2  # more results than this are compared in one sentence


def overview(rows: Sequence[Row], facts: Facts, *, pictures: bool = True) -> Section:
    """Return the summary; it also holds for no rows at all."""
    if not rows:
        return Section(name="summary", title="Summary", words=("No case has been measured yet.",))
    split = main_split(rows)
    chosen = [row for row in rows if split in (ALL, row.split)]
    figures = [item for item in robustness(chosen) if (item.split, item.size_class) == (ALL, ALL)]
    words = [_measured(chosen, rows, facts, split), *_results(figures), *_false_alarms(alarms(rows))]
    if not pictures:
        words.append("This report has no plots: they need matplotlib (pip install meshmark[research]).")
    table = _glance(chosen, figures, alarms(rows))
    return Section(name="summary", title="Summary", words=tuple(words), parts=(table,) if table.rows else ())


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
    """Return a sentence for each scheme and budget, or for many of them one that compares all at a budget."""
    by_mark = _by_mark(figures)
    if len(by_mark) <= _FEW:
        return [text for (scheme, budget), part in by_mark.items() if (text := _result(scheme, budget, part))]
    sentences = []
    for budget in dict.fromkeys(budget for _, budget in by_mark):
        shares = {scheme: _share(part) for (scheme, own), part in by_mark.items() if own == budget}
        known = {scheme: share for scheme, share in shares.items() if share is not None}
        ranked = sorted(known, key=lambda scheme: -known[scheme])
        said = _listed([f"{scheme} {percent(known[scheme])}" for scheme in ranked])
        if known:
            sentences.append(f"Exact ids after an attack, at {budget} strength: {said}.")
    return sentences


def _result(scheme: str, budget: str, part: Sequence[Robustness]) -> str:
    """Return a sentence on the untouched models, all attacks and the worst one; "" for nothing to tell."""
    attacked = [item for item in part if item.attack != UNTOUCHED]
    clean = [item for item in part if item.attack == UNTOUCHED]
    said = [f"from {_with_interval(clean[0].recovered)} of the untouched models"] if clean else []
    if attacked:
        said.append(f"after {percent(_share(part))} of the attacks")
    if not said:
        return ""
    text = f"{scheme} at {budget} strength gives the exact id back {' and '.join(said)}"
    rates = [item.recovered.value for item in attacked]
    if len(set(rates)) > 1:
        worst = [label(item.attack) for item in attacked if item.recovered.value == min(rates)]
        others = f" and {_counted(len(worst) - 1, 'other')}" if len(worst) > 1 else ""
        text += f"; hardest: {worst[0]}{others} ({percent(min(rates))})"
    return text + "."


def _share(part: Sequence[Robustness]) -> float | None:
    """Return the share of attacked trials with an exact id; None without an attack."""
    attacked = [item for item in part if item.attack != UNTOUCHED]
    trials = sum(item.trials for item in attacked)
    return sum(item.recovered.value * item.trials for item in attacked) / trials if trials else None


def _false_alarms(figures: Sequence[Alarms]) -> list[str]:
    counts = {}
    for scheme in sorted({item.scheme for item in figures}):
        part = [a for a in figures if (a.scheme, a.size_class) == (scheme, ALL) and a.trial != "forged"]
        counts[scheme] = (sum(a.found for a in part), sum(a.trials for a in part))
    counts = {scheme: (found, trials) for scheme, (found, trials) in counts.items() if trials}
    if len(counts) > _FEW:
        said = _listed([f"{scheme} {found:,} in {trials:,}" for scheme, (found, trials) in counts.items()])
        return [f"Marks found in trials with nothing to find: {said}."]
    return [_false_alarm(scheme, found, trials) for scheme, (found, trials) in counts.items()]


def _false_alarm(scheme: str, found: int, trials: int) -> str:
    what = {0: "never found a mark", 1: "found a mark once"}.get(found, f"found a mark {found:,} times")
    limit = percent(upper_limit(found, trials), 2)
    return (
        f"In {_counted(trials, 'trial')} with nothing to find, {scheme} {what}: it happens in at most {limit}, "
        "with 95 % confidence."
    )


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
                Cell(text=scheme),
                Cell(text=budget),
                Cell(text=str(max(item.models for item in part))),
                Cell(text=str(max((item.refused for item in part), default=0))),
                estimate(clean),
                estimate(_pooled(pooled.get((scheme, budget), []), "present")),
                estimate(_pooled(pooled.get((scheme, budget), []), "recovered")),
                Cell(text=f"{sum(a.found for a in mine)} of {sum(a.trials for a in mine)}"),
                Cell(text=f"{100 * rms.mean:.3g} %", small=f"worst {100 * rms.worst:.3g} %")
                if rms
                else Cell(text="–"),
                Cell(text=number(speed.embed if speed else None)),
                Cell(text=number(speed.extract if speed else None)),
            )
        )
    columns = (
        *("scheme", "budget", "models", "refused", "untouched: id exact", "attacked: mark found"),
        *("attacked: id exact", "false alarms", "RMS change", "embed s", "extract s"),
    )
    note = (
        "“Attacked” pools all attacks alike; intervals count models, not trials. False alarms are those of all "
        "budgets together. Times are medians."
    )
    return Table(title="At a glance", columns=columns, rows=tuple(rows), note=note)


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
