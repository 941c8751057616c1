"""The check of the smoke benchmark's table sees each fact that does not hold."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest

TOOL = Path(__file__).resolve().parents[3] / "tools" / "check_smoke.py"
SPEC = importlib.util.spec_from_file_location("check_smoke", TOOL)
check_smoke = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(check_smoke)


def row(trial, attack, ber, present, repeat=0):
    return {
        "scheme": "toy",
        "model": "m",
        "budget": "standard",
        "attack": attack,
        "trial": trial,
        "repeat": str(repeat),
        "status": "ok",
        "note": "",
        "rms_over_diagonal": "0.0007",
        "ber": str(ber),
        "present": str(int(present)),
        "recovered": str(int(present)),
    }


def sound():
    bers = np.random.default_rng(1).binomial(64, 0.5, 15) / 64
    return [
        *(row("marked", attack, 0.0, True) for attack in check_smoke.HARMLESS),
        row("marked", "crop:0.03", 0.5, False),
        *(row("wrong key", "none", ber, False, repeat) for repeat, ber in enumerate(bers)),
        row("unmarked", "none", 0.5, False),
    ]


def test_a_sound_table_passes():
    assert list(check_smoke.violations(sound())) == []


@pytest.mark.parametrize(
    ("trial", "attack", "change", "sentence"),
    [
        ("marked", "none", {"ber": "0.015625", "recovered": "0"}, "is read with BER 0.015625"),
        ("marked", "shuffle:1", {"present": "0", "recovered": "0"}, "present 0"),
        ("marked", "crop:0.03", {"status": "timeout", "note": "slow"}, "is timeout: slow"),
        ("marked", "none", {"rms_over_diagonal": "0.00081"}, "moved by 0.00081"),
        ("marked", "none", {"rms_over_diagonal": "0.0"}, "nothing, or beyond its budget"),
        ("wrong key", "none", {"present": "1"}, "finds a mark"),
        ("unmarked", "none", {"present": "1"}, "finds a mark"),
        ("wrong key", "none", {"ber": "0.0"}, "0 of 960 bits wrong"),
        ("wrong key", "none", {"ber": "1.0"}, "960 of 960 bits wrong"),
    ],
)
def test_each_fault_is_seen(trial, attack, change, sentence):
    table = [
        each | change if (each["trial"], each["attack"]) == (trial, attack) else each for each in sound()
    ]
    assert any(sentence in found for found in check_smoke.violations(table))


@pytest.mark.parametrize("trial", ["marked", "wrong key", "unmarked"])
def test_a_table_that_lacks_a_trial_fails(trial):
    assert list(check_smoke.violations([each for each in sound() if each["trial"] != trial]))


def test_an_empty_table_fails():
    assert list(check_smoke.violations([]))
