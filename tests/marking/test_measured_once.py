"""One embedding measures a surface once: calls are counted wherever the functions were imported to."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest
from numpy.typing import NDArray

import meshmark
from meshmark.authentication.checks.checks import check, shapes_of
from meshmark.authentication.checks.setting_search import any_hold, likeliest_setting
from meshmark.authentication.checks.sweep import sweep
from meshmark.authentication.examination import examine
from meshmark.authentication.marks.mending import mended
from meshmark.authentication.marks.plan import plan
from meshmark.authentication.marks.ring_shapes import ring_shapes
from meshmark.authentication.marks.rings import ordered_rings
from meshmark.coding import known_words
from meshmark.coding.keyed import cell_words
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.weld import weld
from meshmark.io import read_mesh, write_mesh
from meshmark.marking import embed, embed_file, extract
from meshmark.mesh import IntArray, Mesh
from meshmark.recovery.mesh_coder import encode_mesh
from meshmark.recovery.miniature import miniature
from tests.imports import import_graph
from tests.keys import ID, KEY
from tests.shapes import pebble

ROOT = Path(meshmark.__file__).parent
COUNTED = (
    weld,
    canonical_frame,
    ordered_rings,
    ring_shapes,
    shapes_of,
    examine,
    check,
    miniature,
    encode_mesh,
    plan,
    mended,
    any_hold,
    likeliest_setting,
    sweep,
)


@contextmanager
def counted() -> Iterator[Counter[str]]:
    """Count the calls of `COUNTED`, in every module of meshmark that has one of them under its name."""
    calls: Counter[str] = Counter()
    for name in sorted(import_graph(ROOT)):  # also those that an embedding imports late
        if not name.startswith("meshmark.research"):
            import_module(name)

    def counting(function: Callable[..., object]) -> Callable[..., object]:
        def called(*arguments: object, **named: object) -> object:
            calls[function.__name__] += 1
            return function(*arguments, **named)

        return called

    patches = [
        patch.object(module, function.__name__, counting(function))
        for function in COUNTED
        for name, module in list(sys.modules.items())
        if name.startswith("meshmark") and getattr(module, function.__name__, None) is function
    ]
    for each in patches:
        each.start()
    try:
        yield calls
    finally:
        for each in patches:
            each.stop()


@pytest.fixture(scope="module")
def of_both_layers() -> Counter[str]:
    """Return what an embedding of both layers calls."""
    with counted() as calls:
        result = embed(Mesh(*pebble(70)), KEY, id=ID)
    assert result.layers == "both"
    assert result.authentication is not None
    return calls


def test_an_embedding_of_both_layers_welds_at_most_twice_and_finds_three_frames(of_both_layers):
    """The input is welded. All other meshes have its points, which is checked instead of welding them anew.

    These are the mesh between the layers, the output (and the marks that were tried before it), and each rounding
    that a tolerance promises to bear. One of them where rounding joins two points is welded, as
    `test_surface_of` shows; here none is. Framed are the input, the mesh with the id and the output.
    """
    calls = of_both_layers
    assert 1 <= calls["weld"] <= 2
    assert 1 <= calls["canonical_frame"] <= 3
    assert calls["ordered_rings"] == 1
    assert calls["ring_shapes"] > 0


def test_both_layers_plan_once_and_code_one_miniature_and_each_surface_that_is_read_is_shaped_once(
    of_both_layers,
):
    """Where a promised rounding leaves a point unread, some marks are mended; the rest is not planned anew."""
    calls = of_both_layers
    assert calls["miniature"] == 1
    assert 1 <= calls["encode_mesh"] <= 3
    assert calls["plan"] == 1
    assert calls["mended"] <= 2
    assert calls["shapes_of"] == calls["examine"] <= 3 * (1 + calls["mended"])
    assert calls["check"] <= 2 * calls["examine"]


def test_an_id_alone_reads_the_rings_of_a_sample_only_for_marks_of_authentication():
    with counted() as calls:
        assert embed(Mesh(*pebble(50)), KEY, id=ID, layers="ownership").authentication is None
    assert calls["any_hold"] == 1  # with the id that marks report, and with this one
    assert calls["likeliest_setting"] == 0
    assert calls["check"] == calls["sweep"] == calls["shapes_of"] == 0  # no shapes but those of the sample


def test_a_search_makes_each_lattice_once_and_hashes_each_of_its_places_once():
    hashed: list[bytes] = []

    def counting(subkey: bytes, coordinates: IntArray, words: int) -> NDArray[np.uint64]:
        hashed.extend(subkey + each.tobytes() for each in coordinates.astype(np.int64))
        return cell_words(subkey, coordinates, words)

    with patch.object(known_words, "cell_words", counting):
        found = extract(Mesh(*pebble(30)), KEY, search="quick")
    assert found.presence == "absent"
    assert len(hashed) > 1000
    # Each strategy at points has lattices of its own.
    assert len(hashed) < 1.5 * len(set(hashed))


def test_a_certificate_measures_nothing_again():
    result = embed(Mesh(*pebble(50)), KEY, id=ID, payload="none")
    with counted() as calls:
        assert result.certificate.vertices == len(result.mesh.vertices)
    assert calls["weld"] == calls["canonical_frame"] == 0


@pytest.mark.parametrize("target", ["out.ply", "out.off"])
def test_a_written_file_that_holds_the_same_positions_is_not_welded_again(tmp_path, target):
    write_mesh(Mesh(*pebble(56)), tmp_path / "in.ply")
    source = read_mesh(tmp_path / "in.ply")
    with counted() as calls:
        result = embed_file(source, tmp_path / target, KEY, id=ID)
        assert result.certificate.vertices == len(source.vertices)
    assert (read_mesh(tmp_path / target).vertices == result.mesh.vertices).all()
    assert 1 <= calls["weld"] <= 2
