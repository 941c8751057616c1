"""The ablation table: what each module of NCDG-LV is worth in what it serves here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from meshmark.research.ablation.modules import EMBEDDINGS, PAPER
from meshmark.research.benchmark.figures.intervals import mean
from meshmark.research.benchmark.figures.labels import label
from meshmark.research.benchmark.page.report_parts import NOTHING, Cell, Table
from meshmark.research.benchmark.paper.ablated_regions import (
    Figures,
    area,
    in_words,
    map_table,
    verdict_table,
)
from meshmark.research.benchmark.paper.compared import standing
from meshmark.research.benchmark.paper.measured import OWN, Group, Measured, db_cell, share_cell
from meshmark.research.benchmark.paper.published_claims import ABLATION, DOUBTS
from meshmark.research.benchmark.run.job import Outcome, Probe

__all__ = ["ablation_tables"]

_SCHEMES = tuple(EMBEDDINGS.values())


def ablation_tables(measured: Measured, probes: Mapping[Probe, Outcome]) -> list[Table]:
    """Return the paper's table beside what is measured, then a table for each module; none without probes."""
    regions, carriers = _found(probes, "regions"), _found(probes, "carriers")
    tables = [_paper(measured, regions)]
    if regions:
        tables += [map_table(regions), verdict_table(regions)]
    if carriers:
        tables.append(_carriers(carriers))
    if all(measured.of(name, "none") for name in _SCHEMES):
        tables.append(_embedding(measured))
    return tables


def _found(probes: Mapping[Probe, Outcome], kind: str) -> list[Figures]:
    return [o.figures for p, o in probes.items() if p.kind == kind and o.status == "ok"]


def _paper(measured: Measured, regions: Sequence[Figures]) -> Table:
    rows = []
    for claim, modules in zip(ABLATION, PAPER, strict=True):
        choice, scheme = modules.map, modules.scheme
        attacks = sorted({row.case.attack for row in measured.rows if row.case.trial == "marked"} - {"none"})
        psnr = measured.values(scheme, ("none",), lambda row: row.psnr_db)
        clean = measured.values(scheme, ("none",), lambda row: row.ber)
        attacked = measured.values(scheme, attacks, lambda row: row.ber)
        rows.append(
            (
                Cell(text=claim.modules),
                Cell(text=f"{claim.train:.2f}"),
                Cell(text=f"{claim.test:.2f}"),
                Cell(text=in_words(choice), small=f"id by {scheme}"),
                db_cell(list(psnr.values())),
                share_cell(list(clean.values())),
                share_cell(list(attacked.values())),
                Cell(text=area(regions, choice, "network")),
            )
        )
    columns = (
        *("the paper's modules", "claimed PSNR, training", "claimed PSNR, test", "here"),
        *(
            "PSNR of the marked model",
            "bit errors, untouched",
            "bit errors, attacked",
            "regions: area under ROC",
        ),
    )
    note = (
        f"Doubts about the paper's table: {DOUBTS['Ablation']} Here saliency and segmentation play no part "
        "in the id, so PSNR and bit errors of a row are those of its embedding, at the same budget; they "
        "serve the map of regions (last column and the next tables). Least significant bits are read "
        "without a network."
    )
    return Table(title="Ablation: the paper's table", columns=columns, rows=tuple(rows), note=note)


def _carriers(carriers: Sequence[Figures]) -> Table:
    rows = []
    for rule, words in (("network", "LM network"), ("rule", "plain rule")):
        own = [figures[rule] for figures in carriers if figures[rule]["errors"]]
        shares = [
            _plain([float(np.mean(f[name])) for f in own]) for name in ("errors", "decoded", "decoded_half")
        ]
        bits = [float(np.mean(f["information"])) for f in own]
        rows.append((Cell(text=words), shares[0], _plain_number(bits), shares[1], shares[2]))
    columns = (
        "extraction",
        "wrong signs",
        "bits per carrier",
        "id from all carriers",
        "id from half of them",
    )
    readings = sum(len(figures["rule"]["errors"]) for figures in carriers)
    note = (
        f"Readings: {readings}, models: {len(carriers)}; after noise 0.5 % and smoothing 10 times by "
        "0.1, in the frame found by a lock that succeeded, as the network is used. Means over "
        "models, 95 % intervals."
    )
    return Table(title="Ablation: extraction, bits of the id", columns=columns, rows=tuple(rows), note=note)


def _embedding(measured: Measured) -> Table:
    attacks = sorted({row.case.attack for row in measured.rows if row.case.trial == "marked"})
    everything = Group(label="all", models=frozenset(row.case.model for row in measured.rows))
    rows = []
    for attack in attacks:
        values = {name: measured.values(name, (attack,), lambda row: row.ber) for name in _SCHEMES}
        lost = measured.values(
            OWN, (attack,), lambda row: None if row.present is None else float(not row.present)
        )
        cells = [share_cell(list(values[name].values())) for name in _SCHEMES]
        rows.append(
            (Cell(text=label(attack)), *cells, Cell(text=standing(values, everything, "%", lost).words))
        )
    columns = ("attack", "barycentre", "least significant bits", "barycentre")
    note = (
        "Bit errors of 64 bits, at the same budget; mean over the models that could be marked, 95 % interval."
    )
    return Table(title="Ablation: embedding", columns=columns, rows=tuple(rows), note=note)


def _plain(values: Sequence[float]) -> Cell:
    """Return a share that has no good end."""
    cell = share_cell(values)
    return Cell(text=cell.text, small=cell.small)


def _plain_number(values: Sequence[float]) -> Cell:
    found = mean(values)
    return (
        Cell(text=NOTHING)
        if found is None
        else Cell(text=f"{found.value:.3f}", small=f"{found.low:.2f}–{found.high:.2f}, n {found.count}")
    )
