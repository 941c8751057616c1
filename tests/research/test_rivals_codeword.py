"""Code bits under a key, the strength for a budget, and the last bits of coordinates."""

from __future__ import annotations

from math import comb, log10

import numpy as np
import pytest

from meshmark.coding.keys import Key
from meshmark.errors import CapacityError
from meshmark.mesh import Mesh
from meshmark.research import SCHEMES
from meshmark.research.schemes.rivals.codeword import chips, coded, order_of, read_code
from meshmark.research.schemes.rivals.host import Host
from meshmark.research.schemes.rivals.lsb import Lsb
from meshmark.research.schemes.rivals.tuning import strongest
from tests.shapes import pebble

KEY = Key(b"c" * 32)
PILOTS = 16


def bits(seed=0):
    return np.random.default_rng(seed).integers(0, 2, 64).astype(np.uint8)


def seen_of(code):
    return 1.0 - 2.0 * code.astype(float)


def test_what_was_coded_is_read():
    found = read_code(seen_of(coded(bits(), KEY, PILOTS)), KEY, PILOTS)
    assert np.array_equal(found.bits, bits())
    assert found.present
    assert found.log10_false_positive == pytest.approx(-PILOTS * log10(2.0))


def test_the_bound_is_the_binomial_tail_of_the_pilots_that_were_seen():
    seen = seen_of(coded(bits(), KEY, PILOTS))
    pilots = np.argsort(order_of(KEY, "rival order", len(seen)))[:PILOTS]
    seen[pilots[:2]] *= -1.0
    seen[pilots[-3:]] = 0.0
    tail = sum(comb(PILOTS - 3, wrong) for wrong in range(3)) / 2 ** (PILOTS - 3)
    found = read_code(seen, KEY, PILOTS, hypotheses=5)
    assert found.log10_false_positive == pytest.approx(log10(5 * tail))
    assert not found.present


def test_nothing_seen_is_nothing_said_and_no_pilots_say_nothing():
    assert read_code(np.zeros(80), KEY, PILOTS).log10_false_positive == 0.0
    assert not read_code(seen_of(coded(bits(), KEY, 0)), KEY, 0).present


def test_wrong_keys_are_believed_as_seldom_as_the_bound_says():
    seen = seen_of(coded(bits(), KEY, PILOTS))
    found = [read_code(seen, Key(number.to_bytes(32, "big")), PILOTS) for number in range(800)]
    # 800 trials at 1 in 1,000 or less: more than 5 have a chance below 0.001
    assert sum(each.present for each in found) <= 5
    errors = np.array([each.bits != bits() for each in found])
    assert abs(errors.mean() - 0.5) < 2.5 / np.sqrt(errors.size)


def test_carriers_are_shared_out_evenly():
    bit, sign = chips(KEY, "any", 1000, 96)
    assert np.ptp(np.bincount(bit, minlength=96)) <= 1
    assert set(sign) == {-1.0, 1.0}


@pytest.mark.parametrize("power", [0.7, 1.0, 1.6])
def test_the_strongest_is_just_within_the_budget(power):
    strength, points = strongest(lambda a: np.array([a**power]), lambda p: float(p[0]), 0.02, 1e-4, 1.0)
    assert 0.97 * 0.02 <= strength**power <= 0.02
    assert points[0] == strength**power


def test_the_strongest_is_the_highest_where_the_budget_allows_it():
    assert strongest(lambda a: np.array([a]), lambda p: float(p[0]), 9.0, 1e-4, 1.0)[0] == 1.0


def test_what_moves_too_far_at_the_least_is_refused():
    with pytest.raises(CapacityError, match="the least mark moves"):
        strongest(lambda a: np.array([1.0 + a]), lambda p: float(p[0]), 0.5, 1e-4, 1.0)


def test_a_host_leaves_out_what_no_face_uses_and_joins_seams():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9], [0, 0, 0], [0, 0, 1]])
    host = Host(Mesh(points, np.array([[0, 1, 2], [4, 2, 5]])))
    assert len(host.points) == 4
    moved = host.moved(host.points + 1.0).vertices
    assert np.array_equal(moved, points + np.array([1, 1, 1, 0, 1, 1])[:, None])


def test_last_bits_fall_to_chance_when_coordinates_are_written_anew():
    points, faces = pebble(60)
    scheme, host = Lsb(), Mesh(points, faces)
    marked = scheme.embed(host, bits(), KEY)
    assert np.array_equal(scheme.extract(marked, KEY).bits, bits())
    single = marked.with_vertices(marked.vertices.astype(np.float32).astype(float))
    turned = marked.with_vertices(marked.vertices @ np.linalg.qr(np.arange(9.0).reshape(3, 3) + np.eye(3))[0])
    for changed in (single, turned):
        assert 0.3 < np.mean(scheme.extract(changed, KEY).bits != bits()) < 0.7


@pytest.mark.parametrize("name", [name for name in SCHEMES if hasattr(SCHEMES[name], "reconstruction")])
def test_what_is_ours_is_said_wherever_the_source_is(name):
    assert "our reconstruction: " + SCHEMES[name].reconstruction in SCHEMES.described(name)
