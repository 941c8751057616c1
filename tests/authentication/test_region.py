"""Evidence, verdicts and scores of regions on planted checks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from meshmark.authentication.checks.checks import Checks
from meshmark.authentication.regions.region import judge_regions
from meshmark.authentication.regions.region_classifier import distortion
from meshmark.authentication.regions.region_evidence import (
    FEATURES,
    _log10_tail,
    region_evidence,
)
from meshmark.errors import InputError
from meshmark.geometry.adjacency import adjacency, unique_edges
from meshmark.geometry.components import connected_parts
from meshmark.research.training import region_training
from meshmark.research.training.region_training import area_under_curve, train_classifier
from meshmark.research.training.region_trials import RegionTrial
from meshmark.segmentation.map_segmentation import Regions

ACROSS = 40


def sheet():
    """Return a square sheet of points and faces, four regions, each of two halves."""
    x, y = np.meshgrid(np.arange(ACROSS), np.arange(ACROSS))
    at = (y * ACROSS + x)[:-1, :-1].ravel()
    faces = np.concatenate(
        [np.stack([at, at + 1, at + ACROSS], 1), np.stack([at + 1, at + 1 + ACROSS, at + ACROSS], 1)]
    )
    region = (x // (ACROSS // 4)).ravel()
    shares = np.full(4, 0.25)
    return (
        faces,
        Regions(region=region, green=(y < ACROSS // 2).ravel(), green_share=shares, blue_share=shares),
        x.ravel(),
        y.ravel(),
    )


def checks_with(altered):
    """Return checks in which exactly the altered points have no mark; a quarter of the others are marks."""
    yes = np.ones(len(altered), bool)
    empty = np.empty(0, np.int64)
    passed = ~altered & (np.arange(len(altered)) % 4 == 0)
    given = {
        "eligible": yes, "passed": passed, "verified": ~altered, "nonce": 1, "index": empty.astype(np.uint32),
        "value": empty.astype(np.uint16), "vertex": empty, "symbol_bits": 8, "step": 1e-3, "log10_chance": -99.0,
        "new_boundary": ~yes,
    }  # fmt: skip
    names = Checks.__dataclass_fields__
    return Checks(**{name: given.get(name, ~yes) for name in names})


def judged(altered):
    faces, regions, _, _ = sheet()
    graph = adjacency(unique_edges(faces), len(altered))
    evidence = region_evidence(graph, regions, checks_with(altered), altered)
    return evidence, judge_regions(evidence, np.arange(12.0).reshape(4, 3))


def test_nothing_altered_is_intact_everywhere():
    evidence, regions = judged(np.zeros(ACROSS**2, bool))
    assert {region.verdict for region in regions} == {"intact"}
    assert {region.probability for region in regions} == {0.0}
    assert evidence.checks.sum() == ACROSS**2
    assert not evidence.failed.any()
    assert regions[2].centre == (6.0, 7.0, 8.0)
    assert regions[2].to_dict()["centre"] == [6.0, 7.0, 8.0]


def test_an_altered_part_makes_its_region_altered_and_is_counted_in_its_half():
    _, _, x, y = sheet()
    altered = (x >= 12) & (x < 18) & (y >= 25) & (y < 32)
    evidence, regions = judged(altered)
    assert [region.verdict for region in regions] == ["intact", "altered", "intact", "intact"]
    assert evidence.failed.tolist() == [[0, 0], [0, 42], [0, 0], [0, 0]]
    assert regions[1].probability == 1.0
    assert regions[1].log10_chance < -3
    assert evidence.home.tolist() == [False, True, False, False]


def test_even_one_point_makes_one_region_altered():
    altered = np.zeros(ACROSS**2, bool)
    altered[ACROSS * 5 + 33] = True
    _, regions = judged(altered)
    assert [region.verdict for region in regions] == ["intact", "intact", "intact", "altered"]


def test_parts_are_those_that_hang_together():
    faces, _, x, y = sheet()
    altered = ((x < 3) & (y < 3)) | ((x > 30) & (y > 30))
    part = connected_parts(adjacency(unique_edges(faces), len(altered)), altered)
    assert (part[~altered] == -1).all()
    assert len(np.unique(part[altered])) == 2
    assert len(np.unique(part[(x < 3) & (y < 3)])) == 1


@given(st.integers(0, 60), st.integers(1, 300))
def test_the_tail_is_the_binomial_one(failed, checks):
    failed = min(failed, checks)
    found = _log10_tail(np.array([float(failed)]), np.array([float(checks)]))[0]
    assert found == pytest.approx(max(binom.logsf(failed - 1, checks, 0.02) / np.log(10.0), -300.0), abs=1e-6)


def test_the_area_under_the_curve_is_the_share_of_pairs_in_order():
    random = np.random.default_rng(1)
    scores, truth = random.integers(0, 9, 60).astype(float), random.random(60) < 0.4
    pairs = scores[truth][:, None] - scores[~truth][None]
    assert area_under_curve(scores, truth) == pytest.approx(((pairs > 0) + 0.5 * (pairs == 0)).mean())
    assert area_under_curve(-scores, truth) == pytest.approx(1.0 - area_under_curve(scores, truth))
    with pytest.raises(InputError, match="one kind"):
        area_under_curve(scores, np.ones(60, bool))


def planted(random):
    """Return a trial whose altered halves have a larger share of failed checks."""
    altered = random.random((8, 2)) < 0.3
    features = random.normal(size=(8, 2, len(FEATURES)))
    features[:, :, 1] += 4.0 * altered
    chance = -np.abs(features[:, :, 2])
    return RegionTrial(
        edit="bump",
        share=0.05,
        features=features,
        log10_chance=chance,
        home=altered.any(axis=1),
        altered=altered,
    )


def test_training_learns_what_is_planted(monkeypatch):
    monkeypatch.setattr(region_training, "RECIPE", replace(region_training.RECIPE, starts=1, passes=15))
    random = np.random.default_rng(2)
    models = {f"model {i}": [planted(random) for _ in range(6)] for i in range(5)}
    trained = train_classifier(models, 0)
    again = train_classifier(models, 0)
    assert np.array_equal(trained.network.weights, again.network.weights)
    rule, network = trained.notes["area under the curve, validation, rule and network"]
    assert network > 0.97 > rule
    trial = planted(random)
    odds = distortion(trial.features, trained.network)
    assert area_under_curve(odds, trial.altered.any(axis=1)) > 0.9
    with pytest.raises(InputError, match="at least 2"):
        train_classifier({"one": [trial]}, 0)


def test_the_shipped_network_calls_clear_cases_right():
    _, _, x, y = sheet()
    altered = (x < 9) & (y < 15)
    evidence, _ = judged(altered)
    odds = distortion(evidence.features)
    assert odds[0] > 0 > odds[1:].max()
