"""The ablation table: what each module of NCDG-LV is worth in what it serves here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from meshmark.benchmark.intervals import mean
from meshmark.benchmark.job import Outcome, Probe
from meshmark.benchmark.labels import label
from meshmark.benchmark.layout import NOTHING, Cell, Table, number, percent
from meshmark.benchmark.paper.claims import ABLATION, DOUBTS
from meshmark.benchmark.paper.compared import standing
from meshmark.benchmark.paper.measured import OWN, Group, Measured, db_cell, share_cell
from meshmark.schemes.ablation.modules import EMBEDDINGS
from meshmark.schemes.ncdg_lv.authentication.region_training import area_under_curve

__all__ = ["ablation_tables"]

Figures = Mapping[str, Mapping[str, Any]]

_SCHEMES = tuple(EMBEDDINGS.values())
# Which of our rows comes nearest to each of the paper's: the map's modules, and the scheme of its embedding.
_NEAREST = (
    ("random + k_means", OWN),
    ("nc_dgg + fuzzy_c_means", "lsb"),
    ("nc_dgg + map", "lsb"),
    ("nc_dgg + map", OWN),
)
_WORDS = {"nc_dgg": "NC-DGG", "random": "random vertices", "laplace_beltrami": "Laplace–Beltrami", "map": "map",
          "k_means": "k-means", "fuzzy_c_means": "fuzzy c-means"}  # fmt: skip


def ablation_tables(measured: Measured, probes: Mapping[Probe, Outcome]) -> list[Table]:
    """Return the paper's table beside what is measured, then a table for each module; none without probes."""
    regions, carriers = _found(probes, "regions"), _found(probes, "carriers")
    tables = [_paper(measured, regions)]
    if regions:
        tables += [_maps(regions), _verdicts(regions)]
    if carriers:
        tables.append(_carriers(carriers))
    if all(measured.of(name, "none") for name in _SCHEMES):
        tables.append(_embedding(measured))
    return tables


def _found(probes: Mapping[Probe, Outcome], kind: str) -> list[Figures]:
    return [o.figures for p, o in probes.items() if p.kind == kind and o.status == "ok"]


def _paper(measured: Measured, regions: Sequence[Figures]) -> Table:
    rows = []
    for claim, (choice, scheme) in zip(ABLATION, _NEAREST, strict=True):
        attacks = sorted({row.case.attack for row in measured.rows if row.case.trial == "marked"} - {"none"})
        psnr = measured.values(scheme, ("none",), lambda row: row.psnr_db)
        clean = measured.values(scheme, ("none",), lambda row: row.ber)
        attacked = measured.values(scheme, attacks, lambda row: row.ber)
        rows.append(
            (
                Cell(claim.modules),
                Cell(f"{claim.train:.2f}"),
                Cell(f"{claim.test:.2f}"),
                Cell(_told(choice), f"id by {scheme}"),
                db_cell(list(psnr.values())),
                share_cell(list(clean.values())),
                share_cell(list(attacked.values())),
                Cell(_area(regions, choice, "network")),
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
    return Table("Ablation: the paper's table", columns, tuple(rows), note)


def _maps(regions: Sequence[Figures]) -> Table:
    rows = []
    for choice in regions[0]:
        own = [figures[choice] for figures in regions if choice in figures]
        agreement = [f["agreement"] for f in own if f["agreement"] is not None]
        called = [value for f in own for value in f["called"]]
        balance = [f["balance"] for f in own]
        rows.append(
            (
                Cell(_told(choice)),
                Cell(number(float(np.median(balance))), f"worst {number(max(balance))}"),
                _plain(agreement),
                _plain(called),
                Cell(f"{number(1000 * float(np.median([f['seconds'] for f in own])))} ms"),
            )
        )
    columns = (
        "saliency + segmentation",
        "balance",
        "same region on a copy",
        "called, of the surface",
        "time",
    )
    note = (
        f"{len(regions)} models. Balance: largest over mean share of a region in its half, 1 is what eq. 7 "
        "asks for, median. Same region on a copy: share of points that the map puts into the same region "
        "after 0.3 % noise, a turn and a shuffle of the vertices; more is better. Called: area of the "
        "regions called altered after local edits; less names the place better. The per-point map, "
        "recovery and id depend on none of these modules."
    )
    return Table("Ablation: saliency and segmentation", columns, tuple(rows), note)


def _verdicts(regions: Sequence[Figures]) -> Table:
    rows = []
    for choice in regions[0]:
        for rule, words in (("network", "LM network"), ("rule", "binomial rule")):
            scores, truth = _pooled(regions, choice, rule)
            called = scores > 0.0
            rows.append(
                (
                    Cell(_told(choice)),
                    Cell(words),
                    Cell(str(len(truth)), f"{int(truth.sum())} altered"),
                    Cell(_area(regions, choice, rule)),
                    Cell(percent(_mean(~called[truth]), 2)),
                    Cell(percent(_mean(called[~truth]), 2)),
                )
            )
    columns = (
        "saliency + segmentation",
        "extraction",
        "regions",
        "area under ROC",
        "altered, missed",
        "intact, called",
    )
    note = (
        "Regions of models marked for authentication, untouched and after local edits: bump, dent, moved, "
        "deleted or replaced part."
    )
    return Table("Ablation: extraction, verdicts on regions", columns, tuple(rows), note)


def _carriers(carriers: Sequence[Figures]) -> Table:
    rows = []
    for rule, words in (("network", "LM network"), ("rule", "plain rule")):
        own = [figures[rule] for figures in carriers if figures[rule]["errors"]]
        shares = [
            _plain([float(np.mean(f[name])) for f in own]) for name in ("errors", "decoded", "decoded_half")
        ]
        bits = [float(np.mean(f["information"])) for f in own]
        rows.append((Cell(words), shares[0], _plain_number(bits), shares[1], shares[2]))
    columns = (
        "extraction",
        "wrong signs",
        "bits per carrier",
        "id from all carriers",
        "id from half of them",
    )
    readings = sum(len(figures["rule"]["errors"]) for figures in carriers)
    note = (
        f"{readings} readings of {len(carriers)} models after noise 0.5 % and smoothing 10 times by "
        "0.1, in the frame found by a lock that succeeded, as the network is used. Means over "
        "models, 95 % intervals."
    )
    return Table("Ablation: extraction, bits of the id", columns, tuple(rows), note)


def _embedding(measured: Measured) -> Table:
    attacks = sorted({row.case.attack for row in measured.rows if row.case.trial == "marked"})
    everything = Group("all", frozenset(row.case.model for row in measured.rows))
    rows = []
    for attack in attacks:
        values = {name: measured.values(name, (attack,), lambda row: row.ber) for name in _SCHEMES}
        lost = measured.values(
            OWN, (attack,), lambda row: None if row.present is None else float(not row.present)
        )
        cells = [share_cell(list(values[name].values())) for name in _SCHEMES]
        rows.append((Cell(label(attack)), *cells, Cell(standing(values, everything, "%", lost).words)))
    columns = ("attack", "barycentre", "least significant bits", "barycentre")
    note = (
        "Bit errors of 64 bits, at the same budget; mean over the models that could be marked, 95 % interval."
    )
    return Table("Ablation: embedding", columns, tuple(rows), note)


def _pooled(regions: Sequence[Figures], choice: str, rule: str) -> tuple[Any, Any]:
    own = [figures[choice] for figures in regions if choice in figures]
    scores = np.concatenate([np.asarray(f[rule], float) for f in own])
    truth = np.concatenate([np.asarray(f["altered"], float) > 0.5 for f in own])
    return scores, truth


def _area(regions: Sequence[Figures], choice: str, rule: str) -> str:
    if not any(choice in figures for figures in regions):
        return NOTHING
    scores, truth = _pooled(regions, choice, rule)
    return f"{area_under_curve(scores, truth):.4f}" if truth.any() and not truth.all() else NOTHING


def _told(choice: str) -> str:
    return " + ".join(_WORDS.get(part, part) for part in choice.split(" + "))


def _plain(values: Sequence[float]) -> Cell:
    """Return a share that has no good end."""
    cell = share_cell(values)
    return Cell(cell.text, cell.small)


def _plain_number(values: Sequence[float]) -> Cell:
    found = mean(values)
    return (
        Cell(NOTHING)
        if found is None
        else Cell(f"{found.value:.3f}", f"{found.low:.2f}–{found.high:.2f}, n {found.count}")
    )


def _mean(flags: Any) -> float | None:
    return float(np.mean(flags)) if len(flags) else None
