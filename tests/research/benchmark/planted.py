"""Rows with planted figures: what a benchmark would give if every rate, error and time were known."""

from __future__ import annotations

import numpy as np

from meshmark.research.benchmark.run.facts import Facts
from meshmark.research.benchmark.run.model_files import size_class
from meshmark.research.benchmark.run.row import Case, Row

ATTACKS = (
    "none", "noise:0.0005", "noise:0.001", "noise:0.005", "noise:0.02", "smoothing:5", "smoothing:30",
    "quantisation:12", "quantisation:9", "quantisation:7", "crop:0.03", "crop:0.3", "simplification:0.5",
    "simplification:0.9", "similarity:1", "file_obj:1", "crop:0.1+noise:0.003+similarity:1",
)  # fmt: skip
GROWTH = 1.25  # seconds of embedding ~ points^GROWTH
REFUSED = "the model has 212 points, the scheme needs about 600; try strength=strong"


def planted_rows(
    schemes=("ncdg_lv",), models=24, budgets=("standard", "subtle"), repeats=1, seed=7
) -> list[Row]:
    """Return rows of all kinds of trial; small models are refused, one case timed out."""
    rng = np.random.default_rng(seed)
    rows = []
    for number, scheme in enumerate(schemes):
        for budget in budgets:
            for i in range(models):
                points = int(300 * 1.28**i)
                model = f"models/{'train' if i % 3 else 'test'}/m{i}.ply"
                for attack in ATTACKS:
                    case = Case("robust", scheme, model, budget, attack, "marked", 3)
                    rows.append(_marked(rng, case, points, number))
                for trial in ("wrong key", "unmarked"):
                    for repeat in range(repeats):
                        case = Case("robust", scheme, model, budget, "none", trial, 3, repeat)
                        rows.append(_empty(rng, case, points))
    return rows


def planted_facts(**more) -> Facts:
    return Facts(
        suite="robust", seed=3, schemes={"ncdg_lv": "NCDG-LV, 2024"}, data="../shared/data/models", models=24,
        command="meshmark bench robust --data ../shared/data/models --out out",
        started="2026-11-22T05:00:00+00:00", versions={"python": "3.11.7", "meshmark": "0.1.0"},
        processor="Some processor", cores=2, memory_mb=4096, workers=2, seconds=4000.0, **more,
    )  # fmt: skip


def _marked(rng, case: Case, points: int, number: int) -> Row:
    common = {"points": points, "size_class": size_class(points), "split": case.model.split("/")[1]}
    if points < 400:
        return Row(case=case, status="refused", note=REFUSED, **common)
    if case.model.endswith("m9.ply") and case.attack == "crop:0.3":
        return Row(case=case, status="timeout", note="took longer than 600 s", **common)
    harm = (
        (ATTACKS.index(case.attack) % 5) * (0.5 + 0.4 * number) * (1.0 if case.budget == "standard" else 1.6)
    )
    wrong = rng.random() < 1.0 - np.exp(-0.25 * harm)
    rms = {"standard": 8e-4, "subtle": 2e-4}[case.budget] * rng.uniform(0.6, 1.0)
    ber = float(rng.integers(1, 36) / 64) if wrong else 0.0
    return Row(
        case=case, status="ok", **common, rms_over_diagonal=rms, max_over_diagonal=4 * rms,
        mrms_over_diagonal=0.5 * rms, hausdorff_over_diagonal=3 * rms,
        psnr_db=-20 * np.log10(rms), paper_psnr_db=50.0, msdm2=300 * rms,
        ber=ber, raw_ber=min(0.5, ber + 0.05), correlation=1 - 2 * ber, present=not wrong or ber < 0.1,
        recovered=not wrong, log10_false_positive=-0.5 if wrong else -15.0, file_seconds=0.01,
        embed_seconds=1e-5 * points**GROWTH, attack_seconds=0.1, extract_seconds=2e-5 * points,
        vertices_per_second=5e4, peak_mb=100.0 + points / 1000,
    )  # fmt: skip


def _empty(rng, case: Case, points: int) -> Row:
    """Return a trial whose bound is a true p, uniform in [0, 1]."""
    p = float(rng.random())
    return Row(
        case=case, status="ok", points=points, size_class=size_class(points), split=case.model.split("/")[1],
        ber=float(rng.binomial(64, 0.5) / 64), present=p < 1e-6, recovered=False, log10_false_positive=np.log10(p),
    )  # fmt: skip
