"""Figures 11 to 13: how much of the watermark is left after smoothing, noise and cropping, as a PSNR."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, log10

from meshmark.research.benchmark.figures.intervals import Estimate, mean
from meshmark.research.benchmark.figures.labels import family_label, label, steps
from meshmark.research.benchmark.page.report_parts import NOTHING, Cell, Entry, Plot, Table, number, percent
from meshmark.research.benchmark.paper.line_plot import entries, panel
from meshmark.research.benchmark.paper.measured import Measured, db_cell, title_of
from meshmark.research.benchmark.paper.published_claims import DOUBTS
from meshmark.research.benchmark.run.row import Row

__all__ = ["watermark_parts", "watermark_psnr"]

_FIGURES: Mapping[int, tuple[str, tuple[str, ...]]] = {
    11: ("smoothing", ("smoothing", "smoothing_half")),
    12: ("Gaussian noise", ("gaussian",)),
    13: ("cropping", ("crop",)),
}


def watermark_psnr(errors: Estimate) -> Estimate:
    """Return the PSNR of a watermark of bits 0 and 1 (Max = 1, MSE = the share of wrong bits), dB.

    Infinite for no errors, 3.0 for guessing.
    """
    low, value, high = (
        -10.0 * log10(share) if share > 0.0 else inf for share in (errors.high, errors.value, errors.low)
    )
    return Estimate(value, low, high, errors.count)


def watermark_parts(measured: Measured, *, pictures: bool) -> list[Table | Plot]:
    """Return figures 11 to 13 as tables, and as plots where `pictures`."""
    parts: list[Table | Plot] = []
    for figure, (words, kinds) in _FIGURES.items():
        attacks = _attacks(measured, kinds)
        if not attacks:
            continue
        if pictures:
            parts.append(_plot(measured, figure, words, kinds))
        parts.append(_table(measured, figure, words, attacks))
    return parts


def _attacks(measured: Measured, kinds: tuple[str, ...]) -> list[str]:
    found = {row.case.attack for row in measured.rows if row.case.trial == "marked"}
    return sorted(
        (text for text in found if len(steps(text)) == 1 and steps(text)[0][0] in kinds),
        key=lambda text: (kinds.index(steps(text)[0][0]), steps(text)[0][1] or 0.0),
    )


def _errors(measured: Measured, scheme: str, attack: str) -> Estimate | None:
    return mean(list(measured.values(scheme, (attack,), lambda row: row.ber).values()))


def _plot(measured: Measured, figure: int, words: str, kinds: tuple[str, ...]) -> Plot:
    panels = []
    legend: tuple[Entry, ...] = ()
    for kind in kinds:
        lines = []
        for name in measured.schemes:
            points = []
            for attack in _attacks(measured, (kind,)):
                found = _errors(measured, name, attack)
                if found is not None:
                    points.append((steps(attack)[0][1] or 0.0, _drawn(found)))
            lines.append((title_of(name), points))
        title = family_label(kind)
        panels.append(
            panel(f"paper-figure-{figure}-{kind.replace('_', '-')}", title, lines, across="strength", up="dB")
        )
        legend = entries(lines)
    return Plot(
        title=f"Figure {figure}: PSNR of the extracted watermark after {words}",
        caption=_CAPTION,
        panels=tuple(panels),
        legend=legend,
    )


def _drawn(errors: Estimate) -> Estimate:
    """Return the PSNR with infinity drawn at half a wrong bit in all payloads read."""
    top = -10.0 * log10(0.5 / (64 * errors.count))
    found = watermark_psnr(errors)
    return Estimate(min(found.value, top), min(found.low, top), min(found.high, top), found.count)


def _table(measured: Measured, figure: int, words: str, attacks: list[str]) -> Table:
    columns = (
        "attack",
        *(f"{title_of(name)}, watermark dB" for name in measured.schemes),
        *(f"{title_of(name)}, model dB" for name in measured.schemes),
    )
    rows = tuple(
        (
            Cell(text=label(attack)),
            *(_cell(_errors(measured, name, attack)) for name in measured.schemes),
            *(db_cell(list(measured.values(name, (attack,), _model).values())) for name in measured.schemes),
        )
        for attack in attacks
    )
    note = f"{_CAPTION} Doubts about the paper's figure {figure}: {DOUBTS[f'Figure {figure}']}"
    return Table(title=f"Figure {figure}: after {words}", columns=columns, rows=rows, note=note)


def _model(row: Row) -> float | None:
    return row.attacked_psnr_db


def _cell(errors: Estimate | None) -> Cell:
    if errors is None:
        return Cell(text=NOTHING)
    found = watermark_psnr(errors)
    heat = max(0.0, 1.0 - 2.0 * errors.value)
    return Cell(
        text=number(found.value), small=f"{percent(errors.value)} of bits wrong, n {errors.count}", heat=heat
    )


_CAPTION = (
    "Watermark dB: the payload as a picture of black and white dots, 10 log10(1 / share of wrong bits), of "
    "the mean over the models read; 3 dB is guessing, ∞ no wrong bit (drawn at half a wrong bit in all of "
    "them). Model dB: the marked and attacked model against the original, which says how strong the attack "
    "is and hardly anything of the scheme."
)
