from __future__ import annotations

import pytest

from meshmark.attacks.table import ATTACKS
from meshmark.research.benchmark.figures.labels import family, label, ordered, steps


@pytest.mark.parametrize(
    ("attack", "words"),
    [
        ("none", "untouched"),
        ("noise:0.005", "noise 0.5 %"),
        ("noise:0.0005", "noise 0.05 %"),
        ("smoothing:30", "smoothing 0.1 × 30"),
        ("quantisation:8", "quantisation 8 bits"),
        ("similarity:1", "similarity"),
        ("file_obj:1", "through OBJ"),
        ("collusion:3", "collusion of 3 copies"),
        ("crop:0.1+noise:0.003+similarity:1", "crop 10 % + noise 0.3 % + similarity"),
        ("elsewhere:2", "elsewhere 2"),
        ("elsewhere:x", "elsewhere"),
    ],
)
def test_attacks_in_words(attack, words):
    assert label(attack) == words


def test_no_two_benchmark_attacks_are_called_alike():
    attacks = [f"{name}:{s:g}" for name, attack in ATTACKS.items() for s in attack.strengths]
    assert len({label(attack) for attack in attacks}) == len(attacks)


def test_a_family_is_one_attack_with_a_strength():
    assert family("noise:0.1") == "noise"
    assert family("none") is None
    assert family("crop:0.1+noise:0.1") is None
    assert steps("crop:0.1+similarity") == (("crop", 0.1), ("similarity", None))


def test_the_order_is_untouched_then_by_table_and_harm_then_chains():
    attacks = [
        "crop:0.1+noise:0.1",
        "quantisation:7",
        "noise:0.05",
        "none",
        "quantisation:12",
        "noise:0.001",
        "zzz:1",
    ]
    assert ordered(set(attacks)) == [
        "none", "noise:0.001", "noise:0.05", "quantisation:12", "quantisation:7", "zzz:1", "crop:0.1+noise:0.1",
    ]  # fmt: skip
