from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from meshmark.errors import InputError
from meshmark.geometry.areas import vertex_areas
from meshmark.geometry.frame import canonical_frame
from meshmark.mesh import Mesh
from meshmark.segmentation import segment
from meshmark.segmentation.map_segmentation import choose_seeds, default_regions, halves, map_regions
from tests.packed import read_packed
from tests.shapes import sphere_with_a_spike

ALL = ["models/train/horse_19851.off.xz", "models/train/open_spot_low_resolution.off.xz"]


def test_shares_are_the_areas_of_the_parts() -> None:
    points, faces, tip = sphere_with_a_spike(40)
    regions = map_regions(points, faces, np.array([tip, 3, 200, 500, 700]))
    areas = vertex_areas(points, faces)
    for half, shares in ((regions.green, regions.green_share), (~regions.green, regions.blue_share)):
        for i in range(5):
            expected = areas[half & (regions.region == i)].sum() / areas[half].sum()
            assert shares[i] == pytest.approx(expected)
    assert regions.balance == pytest.approx(5 * max(regions.green_share.max(), regions.blue_share.max()))
    assert regions.balance < 1.03


def test_the_principal_plane_cuts_across_the_least_extent() -> None:
    points, faces, _ = sphere_with_a_spike(40)
    long = points * [3.0, 1.0, 2.0]
    green = halves(canonical_frame(long, faces).to_canonical(long), vertex_areas(long, faces))
    side = points[:, 1] > 0
    assert np.mean(green == side) > 0.95 or np.mean(green != side) > 0.95


def test_a_flat_sheet_is_cut_across_its_extent() -> None:
    grid = np.stack(np.meshgrid(np.arange(20.0), np.arange(10.0), [0.0]), axis=-1).reshape(-1, 3)
    at = np.arange(200).reshape(10, 20)
    low = np.stack([at[:-1, :-1], at[:-1, 1:], at[1:, :-1]], -1)
    high = np.stack([at[:-1, 1:], at[1:, 1:], at[1:, :-1]], -1)
    faces = np.concatenate([low.reshape(-1, 3), high.reshape(-1, 3)])
    found = segment(Mesh(grid, faces), 4)
    assert 0.4 < found.green.mean() < 0.6
    assert sorted(set(found.region.tolist())) == [0, 1, 2, 3]


def test_seeds_are_the_strongest_and_then_far_from_one_another() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [10, 0, 0], [10, 1, 0], [5, 5, 5]], float)
    beta = np.array([1.0, 0.9, 0.5, 0.6, 0.0])
    assert choose_seeds(points, beta, np.array([0, 1, 3, 2]), 2).tolist() == [0, 3]
    few = choose_seeds(points, beta, np.array([0]), 3)
    assert few[0] == 0
    assert len(set(few.tolist())) == 3


def test_turning_and_shuffling_change_nothing() -> None:
    points, faces, _ = sphere_with_a_spike(30)
    points = points * [1.0, 1.3, 1.7]
    rng = np.random.default_rng(8)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    order = rng.permutation(len(points))
    one = segment(Mesh(points, faces), 6)
    other = segment(Mesh((points @ turn * 5.0 + 2.0)[order], np.argsort(order)[faces]), 6)
    assert np.mean(other.region == one.region[order]) > 0.99
    assert order[other.seeds].tolist() == one.seeds.tolist()


def test_json_fields_and_refusals() -> None:
    points, faces, _ = sphere_with_a_spike()
    mesh = Mesh(points, faces)
    fields = json.loads(json.dumps(segment(mesh, 4).to_dict()))
    assert [set(region) for region in fields["regions"]] == 4 * [
        {"id", "green_share", "blue_share", "salient_vertex"}
    ]
    assert [region["id"] for region in fields["regions"]] == [0, 1, 2, 3]
    assert sum(region["green_share"] for region in fields["regions"]) == pytest.approx(1.0)
    assert fields["balance"] >= 1.0
    for wrong in (0, len(points) + 1):
        with pytest.raises(InputError, match=f"{wrong} regions asked for"):
            segment(mesh, wrong)
    with pytest.raises(InputError, match="no"):
        segment(Mesh(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], float), np.array([[0, 1, 2]])), 1)


def test_the_number_of_regions_grows_with_the_model() -> None:
    assert [default_regions(n) for n in (3, 2500, 35_000, 775_730)] == [2, 6, 23, 32]


@pytest.mark.shared
@pytest.mark.parametrize("name", ALL)
def test_real_models_are_balanced(shared_data: Path, name: str) -> None:
    assert segment(read_packed(shared_data / name)).balance < 1.02
