"""Tables 1 to 4: the paper's numbers, what is measured here, and whether NCDG-LV leads, or why not."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from meshmark.research.benchmark.page.report_parts import NOTHING, Cell, Table, percent
from meshmark.research.benchmark.paper.measured import (
    OWN,
    Group,
    Measured,
    Values,
    db_cell,
    db_estimate,
    share_cell,
    title_of,
)
from meshmark.research.benchmark.paper.published_claims import CLAIMED, DOUBTS, TABLES, Claims
from meshmark.research.benchmark.run.row import Row

__all__ = ["Standing", "standing", "tables"]

# Differences below these are a tie: a bit in a thousand payloads, and what nobody can see.
_TIES = {"%": 2e-5, "dB": 0.05}
# Who reads more of the bits wrong than this guesses, and nobody guesses better than another.
_GUESSING = 0.4
_NOISE = ("gaussian:0.01", "gaussian:0.02", "gaussian:0.05")
_MOVED = "similarity:1"

Figure = Callable[[Row], float | None]


def tables(measured: Measured) -> list[Table]:
    """Return tables 1 to 4, each in the readings that the paper's words allow."""
    return [
        _table(measured, 1, "PSNR 20 log10(diagonal / RMSE)", ("none",), lambda row: row.psnr_db),
        _table(measured, 1, "PSNR in the paper's form, unit models", ("none",), lambda row: row.paper_psnr_db),
        _table(measured, 2, "untouched", ("none",), _ber),
        _table(measured, 2, "turned, moved and resized", (_MOVED,), _ber),
        _table(measured, 3, "10 passes of smoothing by 0.1", ("smoothing:10",), _ber),
        _table(measured, 3, "10 passes of smoothing by 0.5", ("smoothing_half:10",), _ber),
        *(
            _table(
                measured, 4, f"PSNR of the marked and noisy model, noise {percent(float(attack[9:]))}", (attack,),
                lambda row: row.attacked_psnr_db,
            )
            for attack in _NOISE
        ),
        _table(measured, 4, "bit errors, mean of the three strengths", _NOISE, _ber, claimed=False),
    ]  # fmt: skip


def _ber(row: Row) -> float | None:
    return row.ber


def _table(
    measured: Measured,
    number: int,
    reading: str,
    attacks: Sequence[str],
    figure: Figure,
    *,
    claimed: bool = True,
) -> Table:
    claims = TABLES[number]
    values = {name: measured.values(name, attacks, figure) for name in measured.schemes}
    lost = {model: 1.0 - found for model, found in measured.values(OWN, attacks, _present).items()}
    unit = claims.unit if claimed else "%"
    columns = (
        *("models", *(f"{title}, claimed {claims.unit}" for title in CLAIMED.values() if claimed)),
        *(f"{title_of(name)}, measured" for name in measured.schemes),
        "NCDG-LV here",
    )
    rows = tuple(
        (
            Cell(text=group.label),
            *(_claim_cells(claims, group) if claimed else ()),
            *(_cell(values[name], group, unit) for name in measured.schemes),
            Cell(text=standing(values, group, unit, lost).words),
        )
        for group in measured.groups()
    )
    return Table(
        title=f"{claims.name}: {claims.about}; {reading}", columns=columns, rows=rows, note=_note(claims)
    )


def _present(row: Row) -> float | None:
    return None if row.present is None else float(row.present)


def _note(claims: Claims) -> str:
    return (
        f"Doubts about the paper's {claims.name}: {DOUBTS[claims.name]} Measured: mean over the models that "
        "the scheme could mark, 95 % interval, number of models; “NCDG-LV here” compares on the models "
        "that both could mark."
    )


def _claim_cells(claims: Claims, group: Group) -> list[Cell]:
    if group.claim is not None:
        return [Cell(text=f"{value:.2f}") for value in claims.rows[group.claim]]
    if group.average:
        average = claims.average or tuple(float(value) for value in np.mean(claims.rows, axis=0))
        small = "" if claims.average else "mean of rows"
        return [Cell(text=f"{value:.5g}", small=small) for value in average]
    return [Cell(text=NOTHING)] * len(CLAIMED)


def _cell(values: Values, group: Group, unit: str) -> Cell:
    own = [values[model] for model in sorted(group.models & values.keys())]
    return db_cell(own) if unit == "dB" else share_cell(own)


@dataclass(frozen=True, kw_only=True)
class Standing:
    """How NCDG-LV stands among its rivals: in words; whether one is ahead, and whether more than by chance."""

    words: str
    behind: bool = False
    clearly: bool = False


def standing(values: Mapping[str, Values], group: Group, unit: str, lost: Values) -> Standing:
    """Return "leads", or which rivals are level or ahead, by how much, and why.

    values: of each scheme, of each model; less is better of "%", more of "dB". lost: 1 for models in which NCDG-LV
    did not find its mark, and so guesses. A difference is within chance where its 95 % interval, over the models
    that both could mark, holds 0.
    """
    own = values.get(OWN, {})
    level, ahead, doubtful, clearly, compared = [], [], [], False, 0
    for name, theirs in values.items():
        both = sorted(group.models & own.keys() & theirs.keys())
        if name.startswith(OWN) or not both:  # also NCDG-LV read with a reference is no rival of it
            continue
        compared += 1
        sign = 1.0 if unit == "dB" else -1.0
        lead = db_estimate([sign * (own[model] - theirs[model]) for model in both])
        guessing = unit == "%" and all(np.mean([h[m] for m in both]) > _GUESSING for h in (own, theirs))
        if guessing or lead is None or abs(lead.value) <= _TIES[unit]:
            level.append(f"{title_of(name)}{' (both guess)' if guessing else ''}")
            continue
        chance = lead.low <= 0.0 <= lead.high
        if lead.value < 0.0:
            clearly = clearly or not chance
            ahead.append(_difference(name, own, theirs, both, unit, chance))
        elif chance:
            doubtful.append(title_of(name))
    if not compared:
        return Standing(words=NOTHING)
    parts = [f"behind {', '.join(ahead)}{_why(group, unit, own, lost)}"] if ahead else []
    parts += [f"level with {', '.join(level)}"] if level else []
    parts += [f"ahead of {', '.join(doubtful)} within chance"] if doubtful else []
    return Standing(words="; ".join(parts) or "leads", behind=bool(ahead), clearly=clearly)


def _difference(
    name: str, own: Values, theirs: Values, models: Sequence[str], unit: str, chance: bool
) -> str:
    mine, other = (float(np.mean([held[model] for model in models])) for held in (own, theirs))
    within = ", within chance" if chance else ""
    return f"{title_of(name)} ({_said(other, unit)} against {_said(mine, unit)}, n {len(models)}{within})"


def _why(group: Group, unit: str, own: Values, lost: Values) -> str:
    if unit == "dB":
        return ": it uses more of the budget that all share"
    models = sorted(group.models & own.keys())
    gone = [model for model in models if lost.get(model, 0.0) > 0.5]
    kept = [own[model] for model in models if model not in gone]
    if not gone:
        return ""
    rest = f"; in the others {percent(float(np.mean(kept)))} of the bits are wrong" if kept else ""
    return f": in {len(gone)} of {len(models)} models it finds no mark, and guesses{rest}"


def _said(value: float, unit: str) -> str:
    return f"{value:.2f} dB" if unit == "dB" else percent(value, 2)
