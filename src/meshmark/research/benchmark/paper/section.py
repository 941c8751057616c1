"""The part of a report that stands for the paper's tables and figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from meshmark.research import SCHEMES
from meshmark.research.benchmark.figures.aggregate import size_classes
from meshmark.research.benchmark.figures.distortion import distortions
from meshmark.research.benchmark.page.report_parts import NOTHING, Cell, Section, Table
from meshmark.research.benchmark.paper.ablation_table import ablation_tables
from meshmark.research.benchmark.paper.classes import classes_of
from meshmark.research.benchmark.paper.compared import tables
from meshmark.research.benchmark.paper.measured import Measured, title_of
from meshmark.research.benchmark.paper.rates import rate_parts
from meshmark.research.benchmark.paper.salient_point_times import detection_parts
from meshmark.research.benchmark.paper.watermark import watermark_parts
from meshmark.research.benchmark.run.facts import Facts
from meshmark.research.benchmark.run.job import Outcome, Probe
from meshmark.research.benchmark.run.row import Row
from meshmark.research.schemes.scheme import Scheme

__all__ = ["SUITE", "paper_section"]

SUITE = "paper"


def paper_section(
    rows: Sequence[Row], facts: Facts, probes: Mapping[Probe, Outcome], *, pictures: bool
) -> Section:
    """Return the section; it is empty for the rows of another suite."""
    if facts.suite != SUITE or not rows:
        return Section(name=SUITE, title=_TITLE)
    models = sorted({row.case.model for row in rows})
    measured = Measured(rows, classes_of(Path(facts.data), models))
    sizes = {row.case.model: row.size_class or "" for row in rows}
    parts = (
        _equal(measured),
        _marked(measured),
        *tables(measured),
        *detection_parts(probes, sizes, pictures=pictures),
        *rate_parts(measured, pictures=pictures),
        *watermark_parts(measured, pictures=pictures),
        *ablation_tables(measured, probes),
    )
    return Section(name=SUITE, title=_TITLE, words=_WORDS, parts=parts)


def _equal(measured: Measured) -> Table:
    found = {(d.scheme, d.measure): d for d in distortions(measured.rows) if d.size_class == "all"}
    rows = []
    for name in measured.schemes:
        scheme = SCHEMES.get(name)
        known = (str(scheme.bits), "blind" if scheme.blind else "informed") if scheme else (NOTHING, NOTHING)
        cells = [Cell(text=title_of(name)), *(Cell(text=text) for text in known)]
        for measure in ("rms_over_diagonal", "mrms_over_diagonal", "msdm2"):
            value = found.get((name, measure))
            factor, unit = (1.0, "") if measure == "msdm2" else (100.0, " %")
            cells.append(
                Cell(text=NOTHING)
                if value is None
                else Cell(
                    text=f"{factor * value.mean:.3g}{unit}",
                    small=f"worst {factor * value.worst:.3g}{unit}, n {value.count}",
                )
            )
        rows.append((*cells, Cell(text=_origin(scheme) or NOTHING)))
    columns = ("scheme", "payload, bits", "reading", "RMS", "MRMS", "MSDM2", "where it is from")
    note = "Budget of all: at most 0.08 % of the diagonal RMS displacement (strength standard). Means over models."
    return Table(
        title="Payload and distortion of all tables below", columns=columns, rows=tuple(rows), note=note
    )


def _origin(scheme: Scheme | None) -> str:
    """Return where a scheme comes from, and what of it is our reconstruction."""
    ours = getattr(scheme, "reconstruction", "")
    return "; ".join(
        text for text in (scheme.source if scheme else "", ours and f"our reconstruction: {ours}") if text
    )


def _marked(measured: Measured) -> Table:
    sizes = size_classes(measured.rows)
    rows = []
    for name in measured.schemes:
        held = list(measured.of(name, "none").values())
        cells = []
        for size in ("all", *sizes):
            own = [row for row in held if size in ("all", row.size_class)]
            done = sum(row.status == "ok" for row in own)
            broken = sum(row.status not in ("ok", "refused") for row in own)
            cells.append(Cell(text=f"{done} of {len(own)}", small=f"{broken} failed" if broken else ""))
        rows.append((Cell(text=title_of(name)), *cells))
    note = (
        "A model is not marked where the scheme refuses it: too few points, or, for some schemes, not closed."
    )
    return Table(
        title="Models that could be marked", columns=("scheme", "all", *sizes), rows=tuple(rows), note=note
    )


_TITLE = "The paper's tables and figures"
_WORDS = (
    "“Claimed” is what the NCDG-LV paper prints; “measured” was run here, on the models named below, at "
    "the same payload and budget for all schemes. The paper's models, payloads and parameters are not "
    "published, so the two can be compared in order and not in value. Doubts about the paper's numbers "
    "stand under each table.",
    "Rows are the paper's ten models, here the models of the same class, then all models, then size classes.",
)
