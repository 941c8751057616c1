"""Whole runs with quick schemes from outside the package: numbers, misfortunes, and going on after a kill."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from meshmark.errors import InputError, OutputError
from meshmark.research.benchmark.run.run import Plan, run
from meshmark.research.benchmark.run.store import Store
from meshmark.research.benchmark.run.suites import SUITES, cases
from tests.counting import some
from tests.research.benchmark.runs import driver, numbers, rows_in


def test_a_scheme_from_outside_gets_a_row_for_each_case(whole, models):
    names = ("test/deep/odd.off", "tiny.obj", "train/even.ply")
    expected = [case for name in names for case in cases("smoke", "toy", name, 0)]
    assert sorted(row.case for row in whole.rows) == sorted(expected)
    assert whole.facts.schemes == {"toy": "Toy (tests of meshmark)"}
    assert whole.facts.models == 3


def test_rows_tell_the_truth(whole):
    by = {(row.case.model, row.case.attack, row.case.trial): row for row in whole.rows}
    for model, points, split, size in (
        ("test/deep/odd.off", 313, "test", "< 500"),
        ("train/even.ply", 614, "train", "500-2,500"),
    ):
        clean, shuffled = by[model, "none", "marked"], by[model, "shuffle:1", "marked"]
        assert (clean.status, clean.points, clean.split, clean.size_class) == ("ok", points, split, size)
        assert (clean.ber, clean.present, clean.recovered) == (0.0, True, True)
        assert clean.correlation == pytest.approx(1.0)
        assert 0 < clean.rms_over_diagonal <= clean.max_over_diagonal < 0.004
        assert shuffled.present is False
        assert shuffled.recovered is False
        assert by[model, "none", "unmarked"].present is False
        assert by[model, "none", "unmarked"].rms_over_diagonal is None
    wrong = [row for row in whole.rows if row.case.trial == "wrong key" and row.status == "ok"]
    assert len(wrong) == 4
    assert not any(row.present for row in some(wrong))
    assert 0.3 < np.mean([row.ber for row in wrong]) < 0.7  # 64 bits
    assert len({row.ber for row in wrong}) > 1, "each repeat has a key of its own"


def test_a_refused_model_is_refused_in_every_case_that_needs_the_mark(whole):
    rows = [row for row in whole.rows if row.case.model == "tiny.obj"]
    marked = [row for row in rows if row.case.trial != "unmarked"]
    assert {row.status for row in marked} == {"refused"}
    assert {row.note for row in marked} == {"the model has 14 vertices, needs 100"}
    assert {row.points for row in rows} == {14}
    assert {row.status for row in rows if row.case.trial == "unmarked"} == {"ok"}


@pytest.mark.usefixtures("toys")
def test_two_workers_say_what_one_says(whole, models, tmp_path):
    assert numbers(
        run(Plan(suite="smoke", data=models, out=tmp_path, schemes=("toy",), workers=2)).rows
    ) == numbers(whole.rows)


@pytest.mark.usefixtures("toys")
def test_a_case_alone_has_the_same_numbers(whole, models, tmp_path):
    few = run(Plan(suite="smoke", data=models, out=tmp_path, schemes=("toy",), limit=1, workers=1)).rows
    assert numbers(few) == [row for row in numbers(whole.rows) if row.case in {each.case for each in few}]
    assert {row.case.model for row in few} == {"test/deep/odd.off"}


@pytest.mark.usefixtures("toys")
def test_another_seed_gives_other_numbers(whole, models, tmp_path):
    other = run(
        Plan(suite="smoke", data=models, out=tmp_path, schemes=("toy",), limit=1, seed=1, workers=1)
    ).rows
    same = [row for row in whole.rows if row.case.model == other[0].case.model]
    assert [row.rms_over_diagonal for row in other] != [row.rms_over_diagonal for row in same]


@pytest.mark.usefixtures("toys")
def test_a_finished_run_is_not_repeated_and_more_models_only_add(whole, models, tmp_path):
    small = run(Plan(suite="smoke", data=models, out=tmp_path, schemes=("toy",), limit=1, workers=1))
    told = []
    again = run(
        Plan(suite="smoke", data=models, out=tmp_path, schemes=("toy",), limit=1),
        lambda *all: told.append(all),
    )
    assert told == []
    assert again.rows == small.rows
    assert again.resumed == len(small.rows)
    assert again.facts.starts == 2
    grown = run(
        Plan(suite="smoke", data=models, out=tmp_path, schemes=("toy",), workers=1),
        lambda *all: told.append(all),
    )
    assert [done for done, _, _ in told] == list(range(len(small.rows) + 1, len(grown.rows) + 1))
    assert numbers(grown.rows) == numbers(whole.rows)
    assert set(small.rows) <= set(grown.rows)


@pytest.mark.usefixtures("toys")
@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"seed": 3}, "holds a run with the seed 0, expected 3"),
        ({"suite": "speed"}, "holds a run with the suite smoke, expected speed"),
        ({"schemes": ("toy", "broken")}, "holds a run with the schemes toy, expected toy, broken"),
    ],
)
def test_a_folder_keeps_to_its_run(models, tmp_path, change, sentence):
    plan = Plan(suite="smoke", data=models, out=tmp_path, schemes=("toy",), limit=1, workers=1)
    with Store(tmp_path) as store:
        store.begin(replace(run_facts(plan)))
    with pytest.raises(InputError, match=sentence):
        run(replace(plan, **change))


def run_facts(plan):
    from meshmark.research import SCHEMES
    from meshmark.research.benchmark.run.facts import facts_of_now

    titles = {name: f"{SCHEMES[name].title} ({SCHEMES[name].source})" for name in plan.schemes}
    return facts_of_now(plan.suite, plan.seed, titles, plan.data.resolve(), 1)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"suite": "nonsense"}, "'nonsense' is not a suite, expected one of smoke, paper"),
        ({"schemes": ("nonsense",)}, "'nonsense' is not a scheme, expected one of ncdg_lv"),
        ({"workers": 0}, "number of workers is 0"),
        ({"limit": 0}, "limit is 0"),
        ({"time_limit": 0.0}, "time limit is 0"),
        ({"data": Path("/nowhere")}, "/nowhere is not a folder"),
    ],
)
def test_a_plan_that_cannot_be_is_refused(models, tmp_path, change, sentence):
    with pytest.raises(InputError, match=sentence):
        run(replace(Plan(suite="smoke", data=models, out=tmp_path / "new"), **change))


def test_one_folder_one_run_at_a_time(models, tmp_path):
    with Store(tmp_path), pytest.raises(OutputError, match="another benchmark is running"):
        run(Plan(suite="smoke", data=models, out=tmp_path))


@pytest.fixture(scope="module")
def pair(models, tmp_path_factory):
    """A folder with two of the models, of an even and an odd number of vertices."""
    folder = tmp_path_factory.mktemp("pair")
    (folder / "even.ply").write_bytes((models / "train" / "even.ply").read_bytes())
    (folder / "odd.off").write_bytes((models / "test" / "deep" / "odd.off").read_bytes())
    return folder


@pytest.mark.usefixtures("toys")
@pytest.mark.parametrize(
    ("scheme", "status", "note"),
    [
        ("crashing", "killed", "the worker was ended by SIGSEGV"),
        ("hungry", "failed", "needed more than "),
        ("broken", "failed", "ZeroDivisionError: by mistake"),
        ("short", "failed", "the scheme read bits of shape (3,), expected 16 zeros and ones"),
    ],
)
def test_misfortune_is_a_row_and_harms_no_other(pair, tmp_path, scheme, status, note):
    rows = run(Plan(suite="speed", data=pair, out=tmp_path, schemes=(scheme,), workers=2)).rows
    odd = [row for row in rows if row.case.model == "odd.off" or scheme == "short"]
    assert len(rows) == 10
    assert {row.status for row in odd} == {status}
    assert all(row.note.startswith(note) for row in some(odd))
    assert {row.ber for row in odd} == {None}
    assert all(row.embed_seconds > 0 for row in some(odd)), "the mark was made"
    assert all(row.status == "ok" and row.recovered for row in some(rows) if row not in odd)


@pytest.mark.usefixtures("toys")
def test_a_case_that_hangs_is_a_row_and_harms_no_other(pair, tmp_path, monkeypatch):
    # Workers come from a server with the environment of the first run, so this needs a process of its own.
    monkeypatch.setenv("TOY_HUNG", str(tmp_path / "hung"))
    command = driver("speed", pair, tmp_path / "out", "hanging", limit=8.0)
    subprocess.run(command, check=True, timeout=300)
    (lost,) = [row for row in rows_in(tmp_path / "out") if row.status != "ok"]
    assert (lost.case.model, lost.status, lost.note) == ("odd.off", "timeout", "took longer than 8 s")
    assert (tmp_path / "hung").exists()


@pytest.mark.usefixtures("toys")
def test_a_scheme_that_is_not_blind_is_given_the_original(models, tmp_path):
    rows = run(Plan(suite="smoke", data=models, out=tmp_path, schemes=("informed",), limit=1, workers=1)).rows
    found = {(row.case.attack, row.case.trial): row.present for row in rows}
    assert found["none", "marked"] is True
    assert found["none", "unmarked"] is False
    assert {row.status for row in rows} == {"ok"}


@pytest.mark.usefixtures("toys")
def test_models_that_cannot_be_read_are_rows(models, tmp_path):
    folder = tmp_path / "models"
    folder.mkdir()
    (folder / "good.ply").write_bytes((models / "train" / "even.ply").read_bytes())
    (folder / "torn.off").write_text("OFF\n3 1 0\n0 0 0\n")
    (folder / "torn.stl.xz").write_bytes(b"\xfd7zXZ\0 no more")
    rows = run(Plan(suite="speed", data=folder, out=tmp_path / "out", schemes=("toy",), workers=1)).rows
    assert {row.status for row in rows if row.case.model == "good.ply"} == {"ok"}
    for name, words in (("torn.off", "torn.off"), ("torn.stl.xz", "cannot unpack")):
        torn = [row for row in rows if row.case.model == name]
        assert len(torn) == 5
        assert {row.status for row in torn} == {"failed"}
        assert all(words in row.note for row in some(torn))


def test_every_suite_reads_marked_and_lists_its_cases_once():
    for name in some(SUITES):
        found = list(cases(name, "toy", "model.off", 0))
        assert len(found) == len(set(found))
