"""Aggregates against loops that share no code with them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from meshmark.research.benchmark.figures.aggregate import ALL, alarms, main_split, robustness, size_classes
from meshmark.research.benchmark.figures.distortion import distortions
from meshmark.research.benchmark.figures.speed import growth, speeds, timings
from meshmark.research.benchmark.run.row import Case, Row
from tests.counting import Share, some
from tests.research.benchmark.planted import GROWTH, planted_rows

ROWS = planted_rows(("ncdg_lv", "lsb"), models=20)
CASE = Case("robust", "toy", "m", "standard", "none", "marked", 0)


def test_every_group_is_what_a_naive_loop_gives():
    with Share(0.5) as share:
        compared_with_a_naive_loop(share)


def compared_with_a_naive_loop(share: Share) -> None:
    figures = robustness(ROWS)
    seen = set()
    for figure in some(figures):
        part = []
        for row in ROWS:
            own = (row.case.scheme, row.case.budget, row.case.attack, row.case.trial)
            if own != (figure.scheme, figure.budget, figure.attack, "marked"):
                continue
            if figure.split in ("all", row.split) and figure.size_class in ("all", row.size_class):
                part.append(row)
        read = [row for row in part if row.status == "ok"]
        assert figure.trials == figure.models == len(part)
        assert figure.refused == len([row for row in part if row.status == "refused"])
        assert figure.broken == len(part) - len(read) - figure.refused
        assert figure.present.value == pytest.approx(len([r for r in read if r.present]) / len(part))
        assert figure.recovered.value == pytest.approx(len([r for r in read if r.recovered]) / len(part))
        assert (figure.ber is None) == (not read)
        share.case()
        if read:
            share.asserted()
            assert figure.recovered_where_read.value == pytest.approx(
                sum(r.recovered for r in read) / len(read)
            )
            assert figure.ber.value == pytest.approx(sum(r.ber for r in read) / len(read))
            assert figure.raw_ber.value == pytest.approx(sum(r.raw_ber for r in read) / len(read))
            assert figure.correlation == pytest.approx(sum(r.correlation for r in read) / len(read))
        seen.add((figure.scheme, figure.budget, figure.attack, figure.split, figure.size_class))
    assert len(seen) == len(figures)
    wanted = {
        (r.case.scheme, r.case.budget, r.case.attack, split, size)
        for r in ROWS
        if r.case.trial == "marked"
        for split in ("all", r.split)
        for size in ("all", r.size_class)
    }
    assert seen == wanted, "every group that has rows, and no other"


def test_a_refusal_is_a_miss_and_is_shown():
    rows = [
        Row(case=replace(CASE, model=str(i)), status="ok", present=True, recovered=True, ber=0.0)
        for i in range(3)
    ]
    rows.append(Row(case=replace(CASE, model="r"), status="refused", note="too small"))
    (figure,) = robustness(rows)
    assert (figure.recovered.value, figure.refused, figure.broken) == (0.75, 1, 0)
    assert figure.recovered_where_read.value == 1.0
    assert figure.ber.count == 3


@pytest.mark.parametrize("status", ["failed", "timeout", "killed"])
def test_what_broke_is_a_miss_and_is_counted(status):
    (figure,) = robustness([Row(case=CASE, status=status, note="something happened")])
    assert (figure.recovered.value, figure.broken, figure.ber) == (0.0, 1, None)


def test_splits_are_told_apart_only_where_both_exist():
    assert main_split(ROWS) == "test"
    only = [row for row in ROWS if row.split == "train"]
    assert main_split(only) == ALL
    assert {figure.split for figure in robustness(only)} == {ALL}
    assert size_classes(ROWS) == ["< 500", "500-2,500", "2,500-5,000", "5,000-20,000", "> 20,000"]


def test_false_alarms_are_counted_with_their_limit():
    rows = [
        Row(
            case=replace(CASE, trial="wrong key", repeat=i),
            status="ok",
            present=i == 0,
            ber=0.5,
            log10_false_positive=-float(i),
        )
        for i in range(50)
    ]
    rows.append(Row(case=replace(CASE, trial="wrong key", repeat=50), status="refused"))
    (found,) = alarms(rows)
    assert (found.trials, found.found, found.not_read, found.least) == (50, 1, 1, -49.0)
    assert found.limit == pytest.approx(0.0914, abs=1e-4)  # exact binomial tables, 1 of 50
    assert found.ber.count == 50, "every trial has a key of its own"


def test_distortion_counts_each_mark_once():
    found = {(d.scheme, d.budget, d.size_class, d.measure): d for d in distortions(ROWS)}
    first = {}
    for row in sorted(ROWS, key=lambda row: row.case):
        if row.case.trial == "marked" and row.case.scheme == "lsb" and row.rms_over_diagonal is not None:
            first.setdefault((row.case.budget, row.case.model), row)
    for budget in ("standard", "subtle"):
        values = [row.rms_over_diagonal for (b, _), row in first.items() if b == budget]
        figure = found["lsb", budget, "all", "rms_over_diagonal"]
        assert (figure.count, figure.worst) == (len(values), max(values))
        assert figure.mean == pytest.approx(sum(values) / len(values))
        decibels = [row.psnr_db for (b, _), row in first.items() if b == budget]
        assert found["lsb", budget, "all", "psnr_db"].worst == min(decibels)


def test_times_are_medians_and_the_planted_growth_is_found():
    whole = {(s.scheme, s.budget): s for s in speeds(ROWS) if s.size_class == ALL}
    figure = whole["ncdg_lv", "standard"]
    assert figure.embed_growth == pytest.approx(GROWTH)
    assert figure.extract_growth == pytest.approx(1.0)
    assert figure.peak_mb == max(row.peak_mb for row in ROWS if row.peak_mb)
    points = sorted({row.points for row in ROWS if row.status == "ok" and row.embed_seconds})
    middle = (points[len(points) // 2] + points[(len(points) - 1) // 2]) / 2
    assert figure.points == pytest.approx(middle)


def test_growth_needs_three_sizes_that_differ():
    assert growth([100, 200], [1.0, 2.0]) is None
    assert growth([100, 110, 120], [1.0, 2.0, 3.0]) is None
    assert growth([100, 200, 400], [1.0, None, 2.0]) is None
    assert growth([100, 200, 400], [1.0, 4.0, 16.0]) == pytest.approx(2.0)


def test_a_mark_made_once_is_one_time_and_fresh_marks_are_several():
    once = [
        Row(case=replace(CASE, attack=a), status="ok", points=5, embed_seconds=9.0)
        for a in ("none", "noise:0.1")
    ]
    fresh = [
        Row(case=replace(CASE, repeat=i), status="ok", points=5, embed_seconds=s)
        for i, s in enumerate((1.0, 2.0, 6.0))
    ]
    assert timings(once)[0].embed == 9.0
    assert timings(fresh)[0].embed == 2.0
