"""The table of suites names attacks that exist, in the form in which rows name them."""

from __future__ import annotations

import pytest

from meshmark.attacks.chain import parse_chain
from meshmark.attacks.table import ATTACKS
from meshmark.research.benchmark.run.job import Look, Mark, mark_of, marks_of, needs
from meshmark.research.benchmark.run.row import TRIALS, Case
from meshmark.research.benchmark.run.suites import SUITES, cases
from tests.counting import some

LOCAL = {
    "bump", "dent", "move_part", "scale_part", "smooth_part", "add_part", "delete_part", "replace_part", "paste",
}  # fmt: skip
PROTOCOL = {"second_mark", "collusion", "copy"}
STRENGTHS = {"subtle", "standard", "strong"}


@pytest.mark.parametrize("name", SUITES)
def test_every_case_is_a_valid_one_and_appears_once(name):
    found = list(cases(name, "toy", "a/b.off", 7))
    assert len(found) == len(set(found))
    for case in some(found):
        assert str(parse_chain(case.attack)) == case.attack, "one attack, one name"
        assert case.trial in TRIALS
        assert case.budget in STRENGTHS
        assert (case.suite, case.scheme, case.model, case.seed) == (name, "toy", "a/b.off", 7)
    untouched = {case.trial for case in found if case.attack == "none"}
    assert untouched >= ({"marked"} if name == "speed" else {"marked", "unmarked", "wrong key"})


def attacks_of(name):
    return {case.attack for case in cases(name, "toy", "m", 0) if case.trial == "marked"}


def test_robust_has_every_attack_on_the_whole_model():
    names = {name for attack in attacks_of("robust") for name, _ in parse_chain(attack).steps}
    assert names >= ATTACKS.keys() - LOCAL - PROTOCOL - {"gaussian", "mirror"}
    assert {case.budget for case in cases("robust", "toy", "m", 0)} == {"standard", "subtle"}


# The strengths of the 3D mesh watermarking benchmark, for which others' figures are published.
REFERENCE = {
    "noise": (0.0005, 0.001, 0.003, 0.005),
    "smoothing": (5, 10, 30, 50),
    "quantisation": (11, 10, 9, 8, 7),
    "midpoint": (1,),
    "sqrt3": (1,),
    "loop": (1,),
}


def test_robust_can_be_laid_beside_the_reference_numbers():
    assert attacks_of("robust") >= {f"{name}:{s}" for name, strengths in REFERENCE.items() for s in strengths}


def test_paper_has_the_papers_strengths():
    """Sections "Watermark extraction against different attacks", Tables 3 and 4, Figures 11 to 13."""
    assert attacks_of("paper") >= {
        *("smoothing:5", "smoothing:10", "smoothing:15", "smoothing_half:10"),
        *("gaussian:0.01", "gaussian:0.02", "gaussian:0.05", "crop:0.03", "crop:0.06", "crop:0.09"),
    }


def case(attack, trial="marked", suite="security", repeat=0):
    return Case(suite, "toy", "m.off", "standard", attack, trial, 5, repeat)


def test_a_case_needs_its_model_and_its_mark():
    mark = Mark(scheme="toy", owner="m.off", budget="standard", seed=5)
    assert mark_of(case("none")) == mark
    assert needs(case("none")) == [Look("m.off"), mark]
    assert needs(case("none", "wrong key", repeat=3)) == [Look("m.off"), mark]
    assert needs(case("second_mark:1")) == [Look("m.off"), mark]
    assert needs(case("none", "unmarked")) == [Look("m.off")]
    assert needs(mark) == [Look("m.off")]
    assert needs(Look("m.off")) == []


def test_colluders_and_forgers_need_more_marks():
    copies = marks_of(case("collusion:3+noise:0.001"))
    assert [mark.number for mark in copies] == [0, 1, 2]
    assert {mark.owner for mark in copies} == {"m.off"}
    (donor,) = marks_of(case("copy:1", "forged"))
    assert donor.donor
    assert donor.owner == "m.off", "marked with the key that will read"
    assert [mark.donor for mark in marks_of(case("paste:0.1"))] == [False, True]


def test_repeats_share_a_mark_but_where_marking_is_timed():
    assert mark_of(case("none", repeat=1)) == mark_of(case("none", repeat=2))
    assert mark_of(case("none", suite="speed", repeat=1)) != mark_of(case("none", suite="speed", repeat=2))
