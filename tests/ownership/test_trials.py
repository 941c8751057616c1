"""What a trial is charged: the inverses add up to at most 1, so a union bound holds wherever a search stops."""

from __future__ import annotations

import pytest

from meshmark.ownership.search.trials import TrialCounter


def test_the_inverses_of_all_charges_add_up_to_one():
    counter = TrialCounter()
    charges = [counter.charge() for _ in range(2000)]
    assert sum(1.0 / charge for charge in charges) == pytest.approx(1.0, abs=1e-3)
    assert charges == sorted(set(charges))


def test_decodings_of_several_parts_share_one_chance():
    counter, total = TrialCounter(), 0.0
    for part in range(1, 200):
        first = counter.charge_decoding()
        assert first == 2 * part * (part + 1), (
            "a part does not pay for the readings of those before one by one"
        )
        total += 1.0 / first + sum(1.0 / counter.charge_decoding() for _ in range(300))
        counter.begin_part()
    assert total <= 1.0
    assert total == pytest.approx(1.0, abs=0.01)


def test_trials_and_decodings_are_counted_apart():
    counter = TrialCounter()
    assert [counter.charge(), counter.charge_decoding(), counter.charge()] == [2.0, 4.0, 6.0]
