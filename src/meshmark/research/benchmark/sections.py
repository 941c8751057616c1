"""What a report holds, in its order: summary, robustness, false alarms, distortion, time, trouble, words, facts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from meshmark.research.benchmark.figures.aggregate import ALL, alarms, main_split, robustness, size_classes
from meshmark.research.benchmark.figures.distortion import distortions
from meshmark.research.benchmark.figures.speed import speeds
from meshmark.research.benchmark.page.glossary import glossary
from meshmark.research.benchmark.page.overview import overview
from meshmark.research.benchmark.page.report_parts import Cell, Plot, Section, Table
from meshmark.research.benchmark.page.tables import (
    alarm_table,
    attack_tables,
    distortion_table,
    scheme_tables,
    size_tables,
    speed_table,
    trouble_table,
)
from meshmark.research.benchmark.paper.section import paper_section
from meshmark.research.benchmark.run.facts import Facts
from meshmark.research.benchmark.run.job import Outcome, Probe
from meshmark.research.benchmark.run.row import Row

__all__ = ["sections"]


def sections(
    rows: Sequence[Row],
    facts: Facts,
    plots: Mapping[str, Sequence[Plot]],
    probes: Mapping[Probe, Outcome] | None = None,
) -> list[Section]:
    """Return the parts of the report without the empty ones; `plots` by the section they belong to."""
    figures = robustness(rows)
    split, sizes = main_split(rows), size_classes(rows)
    others = [name for name in ("train", ALL) if split == "test" and any(f.split == name for f in figures)]
    compared, found = scheme_tables(figures, split), alarms(rows)
    changes, times = distortions(rows), speeds(rows)
    trouble = trouble_table(rows)
    parts = [
        overview(rows, facts, pictures=bool(plots)),
        paper_section(rows, facts, probes or {}, pictures=bool(plots)),
        Section(
            name="attacks",
            title="What survives which attack",
            words=_READING,
            parts=(
                *(table for table in compared if not table.folded),
                *plots.get("attacks", ()),
                *attack_tables(figures, split),
                *size_tables(figures, split, sizes),
                *(table for table in compared if table.folded),
                *(_renamed(table, name) for name in others for table in attack_tables(figures, name)),
            )
            if figures
            else (),
        ),
        Section(
            name="alarms",
            title="False alarms",
            words=_ALARMS,
            parts=(*plots.get("alarms", ()), alarm_table(found)) if found else (),
        ),
        Section(
            name="distortion",
            title="What the marks change",
            words=_DISTORTION,
            parts=(*plots.get("distortion", ()), distortion_table(changes)) if changes else (),
        ),
        Section(
            name="speed",
            title="Time and memory",
            words=(),
            parts=(*plots.get("speed", ()), speed_table(times)) if times else (),
        ),
        Section(
            name="trouble",
            title="Refused and failed",
            words=_TROUBLE,
            parts=(trouble,) if trouble.rows else (),
        ),
        glossary(rows, facts),
        Section(name="facts", title="How to make this again", words=(), parts=(_facts_table(facts),)),
    ]
    return [part for part in parts if part.parts or part.name == "summary"]


_READING = (
    "“Mark found”: the scheme says that a mark of this key is there. “Id exact”: found, and every bit of the "
    "payload is right. Both count a refused or failed case as a miss. “Bit errors”: share of wrong bits where "
    "something was read; 0 % is perfect, 50 % is guessing.",
    "Small figures are 95 % confidence intervals: Clopper-Pearson for rates, and for means over models the "
    "interval of Gaffke, which becomes the same for values of 0 and 1. Several trials on one model count as one.",
)
_ALARMS = (
    "Models without a mark, marks read with a wrong key, and marks copied from another model: nothing should be "
    "found in any of them.",
)
_DISTORTION = ("Each marked model against its original; a smaller change is harder to see.",)
_TROUBLE = (
    "A refusal is a scheme's own word that a model cannot carry the mark. Failed, timed-out and killed cases are "
    "errors of the scheme, the attack or the machine. All of them are misses in the rates above.",
)


def _renamed(table: Table, split: str) -> Table:
    words = "train split" if split == "train" else "both splits"
    return Table(
        title=f"{table.title} ({words})", columns=table.columns, rows=table.rows, note=table.note, folded=True
    )


def _facts_table(facts: Facts) -> Table:
    rows = []
    for name, value in facts.to_dict().items():
        if value in ("", 0, {}) and name != "seed":
            continue
        text = ", ".join(f"{k} {v}" for k, v in value.items()) if isinstance(value, dict) else str(value)
        if name == "seconds":
            text = _duration(float(value))
        rows.append((Cell(text=_FACTS.get(name, name.replace("_", " "))), Cell(text=text)))
    return Table(title="Run", columns=("what", "value"), rows=tuple(rows))


_FACTS = {
    "started": "started (UTC)",
    "data": "models from",
    "models": "number of models",
    "memory_mb": "memory, MiB",
    "time_limit": "time limit of a case, s",
    "worker_memory_mb": "memory limit of a worker, MiB",
    "seconds": "time of all starts",
    "starts": "starts (1 + resumed)",
}


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {rest} s" if minutes else f"{rest} s"
