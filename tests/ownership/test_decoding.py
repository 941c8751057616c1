"""What one reading says of ids: one, the two of an average, those of a list."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.codec import Codec
from meshmark.ownership.carriers.cells import Cells
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.reading import Reading
from meshmark.ownership.decoding import Listed, decoded, lock_bound
from meshmark.ownership.search.measurement import CellReading, Measurement
from tests.keys import KEY

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
