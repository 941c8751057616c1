"""Which models a benchmark takes, and what it calls them."""

from __future__ import annotations

import gzip
import lzma
from itertools import pairwise

import numpy as np
import pytest

from meshmark.errors import InputError
from meshmark.io import FORMATS
from meshmark.metrics.shape import describe
from meshmark.research.benchmark.run.model_files import (
    SIZE_CLASSES,
    choose,
    find_models,
    load,
    size_class,
    split_of,
    write_shipped,
)
from meshmark.research.benchmark.run.sample_shape import lopsided
from tests.counting import some

# Numbers of points on both sides of every limit.
CLASSES = {
    0: "< 500",
    499: "< 500",
    500: "500-2,500",
    2499: "500-2,500",
    2500: "2,500-5,000",
    4999: "2,500-5,000",
    5000: "5,000-20,000",
    20000: "5,000-20,000",
    20001: "> 20,000",
    10**7: "> 20,000",
}


@pytest.mark.parametrize(("points", "name"), CLASSES.items())
def test_size_classes(points, name):
    assert size_class(points) == name


def test_every_size_class_has_a_model():
    assert {size_class(points) for points in CLASSES} == {name for _, name in SIZE_CLASSES}


def test_models_of_every_format_and_packing_are_found_at_any_depth(tmp_path):
    names = [entry.extensions[0] for entry in FORMATS.values()]
    wanted = {f"deep/er/model{name}{packing}" for name in names for packing in ("", ".gz", ".xz")} | {
        "UPPER.OFF"
    }
    for name in (*wanted, "notes.txt", "deep/.hidden.off", ".cache/model.off", "deep/model.mtl"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    assert find_models(tmp_path) == sorted(wanted)


def test_a_folder_without_models_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"there is no model below .*\.glb"):
        find_models(tmp_path)
    with pytest.raises(InputError, match="is not a folder"):
        find_models(tmp_path / "none")


@pytest.fixture
def sizes(tmp_path):
    """Names in an order that is not that of the sizes: model k has k bytes."""
    names = [f"{(7 * k) % 50:02d}-{k}.off" for k in range(1, 51)]
    for k, name in enumerate(names, 1):
        (tmp_path / name).write_bytes(b" " * k)
    return tmp_path, names


def size(name):
    return int(name.partition("-")[2].removesuffix(".off"))


def test_a_limit_spreads_over_sizes(sizes):
    folder, names = sizes
    assert [size(name) for name in choose(folder, names, 1)] == [26]
    for limit in (3, 7, 15):
        chosen = sorted(map(size, choose(folder, names, limit)))
        assert len(chosen) == limit
        assert np.diff([1, *chosen, 50]).max() <= 1.2 * 50 / limit + 1


def test_a_larger_limit_only_adds(sizes):
    folder, names = sizes
    picks = [set(choose(folder, names, limit)) for limit in range(1, 51)]
    assert all(small < large for small, large in some(pairwise(picks)))
    assert choose(folder, names[::-1], None) == choose(folder, names, 99) == sorted(names)
    assert choose(folder, names[::-1], 9) == sorted(picks[8])


def test_no_model_is_no_limit(sizes):
    folder, names = sizes
    with pytest.raises(InputError, match="limit is 0"):
        choose(folder, names, 0)


@pytest.mark.parametrize(
    ("model", "split"),
    [("train/a.off", "train"), ("models/test/b/a.off", "test"), ("test.off", ""), ("psb/a-test/b.off", "")],
)
def test_the_split_is_a_folder_of_the_path(model, split):
    assert split_of(model) == split


def test_packed_models_read_like_plain_ones(models, tmp_path):
    plain = models / "test" / "deep" / "odd.off"
    data = plain.read_bytes()
    (tmp_path / "odd.off.xz").write_bytes(lzma.compress(data))
    (tmp_path / "odd.off.gz").write_bytes(gzip.compress(data))
    for name in ("odd.off.xz", "odd.off.gz"):
        again = load(tmp_path / name)
        np.testing.assert_array_equal(again.vertices, load(plain).vertices)
        np.testing.assert_array_equal(again.faces, load(plain).faces)


def test_damaged_packings_are_refused_in_words(tmp_path):
    whole = lzma.compress(b"OFF\n" * 1000)
    for name, data in (("torn.off.xz", whole[:-20]), ("not.off.xz", b"OFF")):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(InputError, match=f"cannot unpack .*{name}"):
            load(tmp_path / name)


def test_a_packing_that_unpacks_to_too_much_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("meshmark.research.benchmark.run.model_files._LARGEST_BYTES", 3000)
    (tmp_path / "bomb.off.xz").write_bytes(lzma.compress(b" " * 4000))
    with pytest.raises(InputError, match="unpacks to more than"):
        load(tmp_path / "bomb.off.xz")


def test_models_that_come_along(tmp_path):
    write_shipped(tmp_path)
    names = find_models(tmp_path)
    assert {size_class(describe(load(tmp_path / name)).points) for name in names} == {
        "2,500-5,000",
        "5,000-20,000",
        "> 20,000",
    }


@pytest.mark.parametrize("across", [6, 26, 76])
def test_the_shape_made_by_formula_is_a_closed_surface_facing_outwards(across):
    mesh = lopsided(across)
    shape = describe(mesh)
    assert shape.closed
    assert shape.parts == 1
    assert shape.points - 1.5 * shape.faces + shape.faces == 2, "Euler's formula for a sphere"
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    assert np.einsum("ij,ij->", a, np.cross(b, c)) > 0
