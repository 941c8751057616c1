"""Schemes that read one mark: marked once, and what is read blind serves those that have a reference, too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.research import SCHEMES
from meshmark.research.benchmark.run.job import Mark, Outcome, mark_of
from meshmark.research.benchmark.run.model_files import load_shipped
from meshmark.research.benchmark.run.row import Row
from meshmark.research.benchmark.run.run import Plan, run, schemes_of
from meshmark.research.benchmark.run.schedule import Schedule
from meshmark.research.benchmark.run.shared_readings import answered_blind, blind_of, outcome_of, read_by_both
from meshmark.research.benchmark.run.store import Store
from tests.counting import some
from tests.research.benchmark.runs import numbers
from tests.research.benchmark.test_judging import case

BLIND = case("none", scheme="ncdg_lv")
INFORMED = case("none", scheme="ncdg_lv_original")
SCHEME = """
from meshmark.research.schemes.scheme import SharedMark

class Mine:
    title, source = "Mine", "tests of meshmark"
    bits = 64
    {}
    def embed(self, mesh, bits, key, *, strength="standard"): return mesh
    def extract(self, mesh, key, *, reference=None): return None
"""
SCHEMES_OF_RUN = ("ncdg_lv", "ncdg_lv_original")


def read(present, bound, seconds=1.0, ber=0.0, *, decoded=None):
    figures = {
        **{"ber": ber, "raw_ber": 0.1, "correlation": 1.0 - ber, "present": present, "recovered": present},
        **{"decoded": present if decoded is None else decoded, "log10_false_positive": bound},
        **{"extract_seconds": seconds, "vertices_per_second": 600.0 / seconds},
        **{"attack_seconds": 0.5, "attacked_psnr_db": 60.0, "peak_mb": 10.0 * seconds},
    }
    return Outcome(status="ok", figures=figures)


def test_all_that_read_one_mark_have_one_mark_and_one_key():
    marks = {
        mark_of(replace(BLIND, scheme=name))
        for name in ("ncdg_lv", "ncdg_lv_certificate", "ncdg_lv_original")
    }
    assert marks == {Mark(scheme="ncdg_lv", owner=BLIND.model, budget="standard", seed=3)}
    assert mark_of(case("none", scheme="cho_mean")).scheme == "cho_mean"


def test_a_case_is_read_alone_where_the_run_has_no_blind_one():
    assert blind_of(INFORMED, SCHEMES_OF_RUN) == BLIND
    assert blind_of(INFORMED, ("ncdg_lv_original",)) is None
    assert blind_of(BLIND, SCHEMES_OF_RUN) is None
    assert blind_of(replace(INFORMED, suite="speed"), SCHEMES_OF_RUN) is None, (
        "its times are of each by itself"
    )
    assert blind_of(case("none", scheme="cho_mean"), ("cho_mean", *SCHEMES_OF_RUN)) is None


def test_what_was_decoded_blind_is_not_looked_for_again():
    answered = answered_blind(INFORMED.scheme, read(True, -9.0))
    assert answered.figures["log10_false_positive"] == pytest.approx(-9.0 + np.log10(2.0))
    assert (answered.figures["recovered"], answered.figures["extract_seconds"]) == (True, 1.0)
    assert answered_blind(INFORMED.scheme, read(False, -1.0)) is None
    assert answered_blind(INFORMED.scheme, read(True, -9.0, decoded=False)) is None, "there may be an id"
    assert answered_blind(INFORMED.scheme, read(True, -6.1)) is None, "not enough for two readings"
    assert answered_blind(INFORMED.scheme, Outcome(status="timeout")) is None
    assert answered_blind(BLIND.scheme, read(True, -9.0)) is None, "it reads marks of its own"


def test_what_the_reference_tells_is_taken_at_the_cost_of_both():
    figures = read_by_both(INFORMED.scheme, read(True, -9.0), read(False, -1.0, seconds=3.0, ber=0.5)).figures
    assert (figures["ber"], figures["present"], figures["recovered"]) == (0.0, True, True)
    assert figures["log10_false_positive"] == pytest.approx(-9.0 + np.log10(2.0))
    assert figures["extract_seconds"] == 4.0
    assert figures["vertices_per_second"] == pytest.approx(150.0)
    assert (figures["attack_seconds"], figures["peak_mb"]) == (0.5, 30.0)


def test_what_was_read_blind_is_taken_where_the_reference_tells_nothing():
    blind = read(True, -20.0, seconds=3.0, decoded=False)
    figures = read_by_both(INFORMED.scheme, read(False, -1.0, ber=0.5), blind).figures
    assert (figures["ber"], figures["present"]) == (0.0, True)
    assert figures["log10_false_positive"] == pytest.approx(-20.0 + np.log10(2.0))
    weak = read_by_both(INFORMED.scheme, read(False, 0.0), read(True, -6.1)).figures
    assert (weak["present"], weak["decoded"], weak["recovered"]) == (False, False, False)


def test_a_blind_reading_that_did_not_end_ends_the_others_unless_they_tell():
    lost = Outcome(status="timeout", note="too long")
    assert read_by_both(INFORMED.scheme, read(False, 0.0), lost) == lost
    assert read_by_both(INFORMED.scheme, read(True, -9.0), lost).figures["recovered"] is True
    failed = Outcome(status="failed", note="no mark")
    assert read_by_both(INFORMED.scheme, failed, read(True, -9.0)) == failed


def test_a_case_waits_for_its_blind_reading_but_does_not_fall_with_it():
    schedule = Schedule([INFORMED, BLIND], {}, SCHEMES_OF_RUN)
    given = []
    while schedule:
        job = schedule.take()
        given.append(job)
        schedule.done(job, Outcome(status="failed" if job == BLIND else "ok"))
    assert given[-2:] == [BLIND, INFORMED]
    assert schedule.fallen() == []


def test_a_reference_alone_reads_what_it_finds_and_no_more():
    mesh, key, bits = load_shipped(), Key(bytes(range(32))), np.tile([0, 1, 1, 0], 16).astype(np.uint8)
    marked = SCHEMES["ncdg_lv"].embed(mesh, bits, key)
    scheme = SCHEMES["ncdg_lv_original"]
    whole = marked.vertices[:, 0] > np.quantile(marked.vertices[:, 0], 0.3)
    kept = Mesh(marked.vertices, marked.faces[whole[marked.faces].all(axis=1)])
    found = scheme.extract_by_reference(kept, key, reference=mesh)
    assert found.present
    np.testing.assert_array_equal(found.bits, bits)
    assert found.decoded
    assert found.log10_false_positive <= scheme.extract(kept, key, reference=mesh).log10_false_positive
    assert not scheme.extract_by_reference(kept, Key(bytes(32)), reference=mesh).present


@pytest.mark.usefixtures("toys")
def test_a_run_of_both_says_what_each_says(models, tmp_path):
    def rows(folder, *schemes, workers=1):
        plan = Plan(suite="smoke", data=models, out=tmp_path / folder, schemes=schemes, workers=workers)
        return run(plan).rows

    both = rows("both", "toy", "sorting", workers=2)
    alone = rows("alone", "sorting")
    assert numbers([row for row in both if row.case.scheme == "sorting"]) == numbers(alone)
    told = {
        row.case.scheme: row.recovered for row in both if row.case.attack == "shuffle:1" and row.points > 100
    }
    assert told == {"toy": False, "sorting": True}
    assert len(list((tmp_path / "both" / "marked").glob("*.npz"))) == 2


@pytest.mark.usefixtures("toys")
@pytest.mark.parametrize("status", ["timeout", "failed"])
def test_a_run_goes_on_with_blind_readings_that_did_not_end(models, tmp_path, status):
    plan = Plan(suite="smoke", data=models, out=tmp_path, schemes=("toy", "sorting"), workers=1, limit=1)
    run(plan)
    with Store(tmp_path) as store:
        store._base.execute("DELETE FROM rows WHERE scheme = 'sorting'")
        store._base.execute("UPDATE rows SET status = ?, note = 'lost' WHERE scheme = 'toy'", [status])
    again = [row for row in run(plan).rows if row.case.scheme == "sorting"]
    told = [row for row in again if row.status == "ok"]
    assert {(row.status, row.note) for row in again} == {("ok", ""), (status, "lost")}
    assert all(row.recovered for row in some(told))
    assert "shuffle:1" in {row.case.attack for row in told}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("blind, shared_mark = True, SharedMark(scheme='ncdg_lv', log10_present=-6.0)", "is blind"),
        (
            "blind, shared_mark = False, SharedMark(scheme='ncdg_lv', log10_present=-6.0)",
            "lacks extract_by_reference",
        ),
    ],
)
def test_a_scheme_that_cannot_share_a_mark_is_refused(tmp_path, text, message):
    (tmp_path / "mine.py").write_text(SCHEME.format(text))
    with pytest.raises(InputError, match=message):
        SCHEMES[str(tmp_path / "mine.py")]


@pytest.mark.parametrize(
    ("other", "bits"), [("none of these", 64), ("ncdg_lv", 16), ("ncdg_lv_original", 64)]
)
def test_a_run_is_refused_where_there_is_no_such_mark(tmp_path, other, bits):
    text = f"blind, shared_mark = False, SharedMark(scheme={other!r}, log10_present=-6.0)"
    path = tmp_path / "mine.py"
    path.write_text(
        SCHEME.format(text).replace("bits = 64", f"bits = {bits}") + "    extract_by_reference = extract\n"
    )
    with pytest.raises(InputError, match=f"reads the marks of '{other}'"):
        schemes_of(Plan(suite="smoke", data=None, out=tmp_path, schemes=(str(path),)))


def test_an_attribute_of_that_name_is_no_shared_mark(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(SCHEME.format("blind, shared_mark = True, 5"))
    assert mark_of(replace(BLIND, scheme=str(path))).scheme == str(path)


@pytest.mark.usefixtures("toys")
def test_a_run_goes_on_with_what_was_read_blind_before(models, tmp_path):
    plan = Plan(suite="smoke", data=models, out=tmp_path, schemes=("toy", "sorting"), workers=1, limit=1)
    first = run(plan)
    with Store(tmp_path) as store:
        store._base.execute("DELETE FROM rows WHERE scheme = 'sorting'")
    again = run(plan)
    assert again.resumed == len([row for row in some(first.rows) if row.case.scheme == "toy"])
    assert numbers(again.rows) == numbers(first.rows)


def test_a_row_gives_back_what_was_read():
    outcome = read(True, -8.0)
    row = Row(case=BLIND, status="ok", **outcome.figures)
    assert outcome_of(row) == outcome
