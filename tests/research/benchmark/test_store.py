"""Rows come back as they went in, and a store belongs to one run."""

from __future__ import annotations

import sqlite3
from dataclasses import fields, replace

import pytest

from meshmark.errors import InputError, OutputError
from meshmark.research.benchmark.run.facts import Facts, facts_of_now
from meshmark.research.benchmark.run.job import Look, Mark, Outcome
from meshmark.research.benchmark.run.row import Case, Row
from meshmark.research.benchmark.run.store import NAME, Store

CASE = Case("smoke", "toy", "a/b ü'.off", "standard", "noise:0.001", "marked", 2**62, 1)
FULL = Row(
    case=CASE,
    status="ok",
    note="",
    points=3,
    size_class="< 500",
    split="test",
    ber=0.1 + 0.2,
    present=True,
    recovered=False,
    log10_false_positive=-12.25,
    extract_seconds=1e-9,
)
FACTS = Facts(
    suite="smoke",
    seed=1,
    schemes={"toy": "Toy (tests)"},
    data="/data",
    models=3,
    command="x",
    versions={"meshmark": "1"},
)


@pytest.fixture
def store(tmp_path):
    with Store(tmp_path) as store:
        yield store


def test_rows_come_back_equal_and_sorted(store):
    bare = Row(case=replace(CASE, attack="crop:0.1"), status="failed", note="a 'sentence'; with --signs\n")
    for row in (FULL, bare):
        store.add_row(row)
    assert store.rows() == [bare, FULL]
    assert store.rows()[1].present is True
    assert store.rows()[1].recovered is False
    assert store.rows()[0].present is None
    assert store.cases() == {CASE, bare.case}


def test_a_case_has_one_row(store):
    store.add_row(FULL)
    store.add_row(replace(FULL, ber=0.5))
    assert [row.ber for row in store.rows()] == [0.5]


@pytest.mark.parametrize("name", [field.name for field in fields(Case)])
def test_cases_that_differ_in_one_field_are_two(store, name):
    value = getattr(CASE, name)
    store.add_row(FULL)
    store.add_row(replace(FULL, case=replace(CASE, **{name: value + (1 if isinstance(value, int) else "x")})))
    assert len(store.rows()) == 2


def test_jobs_come_back_and_kinds_do_not_mix(store):
    outcome = Outcome(
        status="ok", note="note", figures={"points": 3, "psnr_db": None, "rms_over_diagonal": 1 / 3}
    )
    marks = [Mark(scheme="toy", owner="m", budget="standard", seed=1, number=number) for number in (0, 1)]
    store.add_job(Look("m"), outcome)
    store.add_job(marks[0], Outcome(status="refused", note="too small"))
    assert store.job(Look("m")) == outcome
    assert store.job(marks[0]) == Outcome(status="refused", note="too small")
    assert store.job(marks[1]) is None


def test_everything_is_there_for_the_next_to_open_it(tmp_path):
    with Store(tmp_path) as first:
        first.begin(FACTS)
        first.add_row(FULL)
        reader = sqlite3.connect(tmp_path / NAME)
        assert reader.execute("SELECT model, ber FROM rows").fetchall() == [(CASE.model, FULL.ber)]
        reader.close()
    with Store(tmp_path) as second:
        assert second.rows() == [FULL]
        assert second.facts() == FACTS


def test_facts_add_up_the_time_of_all_starts(store):
    assert store.facts() is None
    for seconds in (2.0, 3.0):
        store.begin(replace(FACTS, command=f"took {seconds}"))
        store.spent(1.0)
        store.spent(seconds)
    assert store.facts() == replace(FACTS, command="took 3.0", seconds=5.0, starts=2)


@pytest.mark.parametrize(
    "change",
    [
        {"suite": "paper"},
        {"seed": 2},
        {"schemes": {"toy": "Toy (tests)", "other": "Other"}},
        {"data": "/elsewhere"},
        {"versions": {"meshmark": "2"}},
    ],
)
def test_another_run_is_refused_in_one_sentence(store, change):
    store.begin(FACTS)
    with pytest.raises(InputError, match=r"holds a run with the .*, expected .*; choose another --out"):
        store.begin(replace(FACTS, **change))
    assert store.facts().starts == 1


@pytest.mark.parametrize("change", [{"models": 99}, {"workers": 7}, {"command": "y"}, {"commit": "abc"}])
def test_more_models_or_workers_are_the_same_run(store, change):
    store.begin(FACTS)
    store.begin(replace(FACTS, **change))
    assert store.facts().starts == 2


def test_only_one_process_at_a_time(tmp_path):
    with Store(tmp_path), pytest.raises(OutputError, match="another benchmark is running"):
        Store(tmp_path)
    with Store(tmp_path):
        pass


def test_a_file_that_is_no_store_is_refused(tmp_path):
    (tmp_path / NAME).write_bytes(b"nonsense" * 1000)
    with pytest.raises(OutputError, match="cannot use"):
        Store(tmp_path)


def test_facts_of_now_are_of_this_machine(tmp_path):
    import platform

    import numpy

    import meshmark

    facts = facts_of_now("smoke", 1, {}, tmp_path, 2, workers=3)
    assert facts.versions["python"] == platform.python_version()
    assert facts.versions["numpy"] == numpy.__version__
    assert facts.versions["meshmark"] == meshmark.__version__
    assert facts.cores >= 1
    assert facts.memory_mb > 100
    assert facts.workers == 3
    assert Facts(**facts.to_dict()) == facts


def test_a_store_with_other_columns_is_refused(tmp_path):
    with Store(tmp_path):
        pass
    base = sqlite3.connect(tmp_path / NAME)
    base.execute("ALTER TABLE rows DROP COLUMN msdm2")
    base.close()
    for _ in range(2):
        with pytest.raises(InputError, match="was made by another version of meshmark"):
            Store(tmp_path)
