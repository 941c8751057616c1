"""What the coordinates of a fingerprint say."""

from __future__ import annotations

import numpy as np

from meshmark.coding.codec import Codec
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.fingerprint.parameters import PILOTS, WITNESSES
from meshmark.ownership.fingerprint.roles import Said, are_pilots, are_witnesses, fingerprint_lattice
from meshmark.ownership.points.point_lattice import PointLattice
from tests.keys import ID, KEY

CODEC = Codec(KEY)
LABEL = Label(bytes(16))
CUBES = np.random.default_rng(0).integers(-20, 20, (5000, 3))
KEYS = fingerprint_lattice(KEY, LABEL).keys(CUBES)


def test_roles_are_drawn_in_their_shares_and_do_not_overlap():
    draw = np.random.default_rng(1).random(100_000)
    pilots, witnesses = are_pilots(draw), are_witnesses(draw)
    assert abs(pilots.mean() - PILOTS) < 0.006
    assert abs(witnesses.mean() - WITNESSES) < 0.006
    assert not (pilots & witnesses).any()
    assert abs(pilots[draw < 0.1].mean() - PILOTS) < 0.02  # whichever share of the coordinates carries


def test_pilots_say_0_witnesses_the_hash_and_all_others_the_word():
    said = Said.of(CODEC, ID).bits(KEYS)
    pilots, witnesses = are_pilots(KEYS.draw), are_witnesses(KEYS.draw)
    others = ~pilots & ~witnesses
    assert not said[pilots].any()
    assert np.array_equal(said[witnesses], CODEC.witness(ID)[KEYS.code_index[witnesses]])
    assert np.array_equal(said[others], CODEC.encode(ID)[KEYS.code_index[others]])
    assert 0.4 < said[~pilots].mean() < 0.6


def test_words_add_up_and_witnesses_do_not():
    ids = (3, 5, 9)
    nobody = CODEC.decode(1.0 - 2.0 * np.bitwise_xor.reduce([CODEC.encode(each) for each in ids])).id
    assert nobody not in (None, *ids)
    total = np.bitwise_xor.reduce([CODEC.witness(each) for each in ids])
    assert 0.45 < (total == CODEC.witness(nobody)).mean() < 0.55


def test_it_has_nothing_in_common_with_marks_at_points():
    points = PointLattice.keyed(KEY, LABEL)
    own = fingerprint_lattice(KEY, LABEL)
    assert np.abs(points.axes - own.axes).max() > 0.1
    assert np.abs(points.keys(CUBES).dither - KEYS.dither).mean() > 0.2
