"""What one reading says of ids: one, the two of an average, those of a list."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshmark.coding.codec import Codec
from meshmark.coding.message import PRESENCE, short_id
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.decoding import Listed, decoded, lock_bound
from meshmark.ownership.search.measurement import CellReading, Measurement
from tests.keys import ID, KEY

CODEC = Codec(KEY)
NOBODY = Listed(ids=(), words=CODEC.words([]))


def reading(ids: tuple[int, ...], count: int = 700, noise: float = 0.3) -> Reading:
    """Return what the average of copies with these ids shows; one without ids shows phases of nothing."""
    random = np.random.default_rng(count)
    nodes = np.unique(random.integers(-9, 9, (2 * count, 3)), axis=0)[:count]
    ones = np.ones(len(nodes))
    cells = Cells(
        nodes=nodes, offset=0.0 * ones, normal=np.eye(3)[0] * ones[:, None], mass=ones, flatness=ones
    )
    measured = Measurement.of(Lattice.keyed(KEY, 0.2, Label(bytes(16))), cells)
    keys = measured.keys
    if ids:
        share = np.mean(
            [np.where(keys.pilot, 0, CODEC.encode(each)[keys.code_index]) for each in ids], axis=0
        )
        phase = np.pi * share * random.choice([-1.0, 1.0], len(nodes)) + noise * random.normal(
            size=len(nodes)
        )
    else:
        phase = random.uniform(0.0, 2.0 * np.pi, len(nodes))
    return CellReading.of(measured, 0.06, phase, 1.0)


def test_one_copy_names_its_id():
    found = decoded(CODEC, reading((7,)), NOBODY)
    assert (found.ids, found.id, found.present) == ((7,), 7, True)


def test_an_average_of_two_copies_names_both_ids():
    found = decoded(CODEC, reading((9, 7)), NOBODY)
    assert (found.ids, found.id, found.present) == ((7, 9), None, True)
    assert found.log10_false_positive < -20.0


def test_an_average_of_three_copies_names_those_that_are_listed():
    average = reading((7, 9, 11))
    ids = (5, 7, 9, 11, 13)
    found = decoded(CODEC, average, Listed(ids=ids, words=CODEC.words(ids)))
    assert set(found.ids) == {7, 9, 11}
    assert found.id is None


@pytest.mark.parametrize("noise", [1.3, 1.4])
def test_a_listed_id_is_named_where_it_is_one_of_too_many(noise):
    worn = reading((7,), 300, noise)
    ids = tuple(range(16))
    assert decoded(CODEC, worn, NOBODY) is None
    assert decoded(CODEC, worn, Listed(ids=ids, words=CODEC.words(ids))).ids == (7,)


def test_phases_of_nothing_name_nobody():
    nothing = reading(())
    ids = tuple(range(16))
    assert lock_bound(nothing) > -3.0
    assert decoded(CODEC, nothing, NOBODY) is None
    assert decoded(CODEC, nothing, Listed(ids=ids, words=CODEC.words(ids))) is None


@pytest.mark.parametrize("identity", [short_id(7), PRESENCE])
def test_a_mark_of_fewer_bits_is_told_where_its_lock_is_credible(identity):
    found = decoded(CODEC, reading((identity,)), NOBODY)
    assert (found.ids, found.present) == ((identity,), True)
    assert found.log10_false_positive < -20.0
    assert len(found.log10_words) == (identity != PRESENCE)
    assert decoded(CODEC, reading(()), NOBODY) is None


@pytest.mark.parametrize("identity", [7, ID, short_id(7), short_id(8)])
@pytest.mark.parametrize("count", [300, 700, 2000])
def test_an_id_with_every_bit_turned_round_is_told_and_no_other(identity, count):
    """Words of a code agree with four fifths of the complement of others."""
    right = reading((identity,), count)
    turned = replace(right, phase=right.phase + np.where(right.keys.pilot, 0.0, np.pi))
    assert decoded(CODEC, right, NOBODY).ids == (identity,)
    assert decoded(CODEC, turned, NOBODY).ids == (identity,)


def test_fewer_bits_pay_more_and_those_of_64_hardly():
    """The chance that is left for 64 bits is 98 % of what it was."""
    few = {each: decoded(CODEC, reading((each,), 150, 0.1), NOBODY) for each in (7, short_id(7), PRESENCE)}
    lock, word = few[7].reading.log10_chance, few[7].log10_words[0]
    alone = CODEC.decode(few[7].reading.observed()).log10_chance
    assert word - alone == pytest.approx(np.log10(3.0 / 0.98))
    assert few[short_id(7)].log10_words[0] == pytest.approx(
        CODEC.decode_short(few[short_id(7)].reading.observed()).log10_chance + np.log10(200.0)
    )
    chance = few[PRESENCE].reading.log10_chance + CODEC.presence_chance(few[PRESENCE].reading.observed())
    assert few[PRESENCE].log10_false_positive == pytest.approx(
        chance + 2.0 + np.log10(1.0 - chance * np.log(10.0))
    )
    assert lock < -20.0


def test_a_listed_id_of_32_bits_is_told_from_few_carriers():
    ids = (short_id(7), short_id(8), 9)
    average = reading((short_id(8),), 60, 0.1)
    assert decoded(CODEC, average, Listed(ids=ids, words=CODEC.words(ids))).ids == (short_id(8),)
