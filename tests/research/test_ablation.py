"""The modules of NCDG-LV and those put in their places."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.attacks import find_attack
from meshmark.errors import CapacityError, InputError
from meshmark.geometry.weld import weld
from meshmark.mesh import Mesh
from meshmark.research.ablation.detection_speed import detection_figures
from meshmark.research.ablation.modules import FULL, SALIENCY, SEGMENTATION, Modules, region_map
from meshmark.research.ablation.region_maps import CHOICES, agreement, region_figures
from meshmark.research.ablation.soft_bits import carrier_figures
from meshmark.segmentation.analysis import segment
from tests.counting import some
from tests.low_poly import ball
from tests.shapes import pebble


@pytest.fixture(scope="module")
def surface():
    return weld(Mesh(*pebble()))


def test_the_full_system_has_the_map_of_the_report(surface):
    expected = segment(Mesh(*pebble()))
    found = region_map(surface, FULL, np.random.default_rng(0))
    assert np.array_equal(found.region[surface.point_of_vertex], expected.region)
    assert found.balance == pytest.approx(expected.balance)


@pytest.mark.parametrize("saliency", SALIENCY)
@pytest.mark.parametrize("segmentation", SEGMENTATION)
def test_every_choice_parts_the_whole_surface(surface, saliency, segmentation):
    modules = Modules(saliency=saliency, segmentation=segmentation)
    one, other = (region_map(surface, modules, np.random.default_rng(3)) for _ in range(2))
    assert np.array_equal(one.region, other.region), "the same random numbers give the same map"
    assert set(one.region) == set(range(len(one.green_share)))
    assert one.green_share.sum() == pytest.approx(1.0)
    assert one.balance >= 1.0 - 1e-9


@pytest.mark.parametrize("saliency", [name for name in SALIENCY if name != "random"])
def test_salient_points_do_not_depend_on_the_place_of_the_model(surface, saliency):
    turned = find_attack("similarity")(Mesh(surface.points, surface.faces), 1, np.random.default_rng(2))
    found = [
        set(SALIENCY[saliency](p, surface.faces, np.random.default_rng(0))[1])
        for p in (surface.points, turned.vertices)
    ]
    assert found[0]
    assert len(found[0] ^ found[1]) <= 0.1 * len(found[0])


def test_the_map_is_the_most_balanced(surface):
    balance = {m: region_map(surface, m, np.random.default_rng(0)).balance for m in CHOICES}
    assert balance[FULL] < min(balance[Modules(segmentation=name)] for name in ("k_means", "fuzzy_c_means"))


@pytest.mark.parametrize("name", ["saliency", "segmentation", "embedding", "extraction"])
def test_an_unknown_module_is_refused(name):
    with pytest.raises(InputError, match=f"'nonsense' is no {name}, expected one of"):
        Modules(**{name: "nonsense"})


def test_agreement_does_not_see_the_numbers_of_regions():
    rng = np.random.default_rng(5)
    one = rng.integers(0, 6, 3000)
    assert agreement(one, rng.permutation(6)[one]) == 1.0
    half = np.where(np.arange(3000) < 1500, one, (one + 1) % 6)
    assert agreement(one, half) == pytest.approx(0.5, abs=0.05)
    assert agreement(one, rng.integers(0, 6, 3000)) < 0.25


def test_figures_of_regions_are_of_all_choices():
    figures = region_figures(Mesh(*pebble()), np.random.default_rng(1))
    assert set(figures) == {m.map for m in CHOICES}
    full = figures["nc_dgg + map"]
    assert full["agreement"] > 0.5
    assert len(full["altered"]) == len(full["network"]) == len(full["rule"])
    scores, truth = np.array(full["network"]), np.array(full["altered"]) > 0.5
    assert truth.any()
    assert not truth.all()
    assert (scores[truth] > 0).mean() > 0.8
    assert (scores[~truth] > 0).mean() < 0.2
    assert all(0.0 < share < 1.0 for share in some(full["called"]))


def test_times_are_of_all_ways():
    figures = detection_figures(Mesh(*pebble()), np.random.default_rng(1))
    assert set(figures) == set(SALIENCY)
    assert all(each["seconds"] > 0.0 and each["points"] > 0 for each in some(figures.values()))
    with pytest.raises(CapacityError, match="no face"):
        detection_figures(Mesh(np.eye(3), np.zeros((0, 3), np.int64)), np.random.default_rng(1))


def test_a_model_that_carries_at_its_points_has_no_cells_to_read():
    with pytest.raises(CapacityError, match="the cells of the model have no room"):
        carrier_figures(Mesh(*ball(2)), np.random.default_rng(0))
