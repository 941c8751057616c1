"""Random numbers depend on every part of what they are for."""

from __future__ import annotations

import hashlib

import numpy as np

from meshmark.research.benchmark.run.seeds import bits_for, generator_for, hashed, key_for


def test_the_hash_is_blake2b_of_the_parts_as_json():
    expected = hashlib.blake2b(b'["a", 1, ""]', digest_size=32, person=b"meshmark bench").digest()
    assert hashed("a", 1, "") == expected


def test_parts_neither_run_together_nor_change_places():
    parts = [(), ("a",), ("a", "b"), ("ab",), ("b", "a"), ("a", "b", ""), ("a", 1), ("a", "1"), (1, "a")]
    assert len({hashed(*each) for each in parts}) == len(parts)
    assert len({key_for(*each) for each in parts}) == len(parts)
    assert len({bits_for(64, *each).tobytes() for each in parts}) == len(parts)
    assert len({generator_for(*each).bytes(8) for each in parts}) == len(parts)


def test_the_same_parts_give_the_same_numbers():
    assert key_for("x", 3) == key_for("x", 3)
    np.testing.assert_array_equal(bits_for(64, "x", 3), bits_for(64, "x", 3))
    assert generator_for("x", 3).bytes(32) == generator_for("x", 3).bytes(32)


def test_keys_bits_and_generators_have_nothing_in_common():
    assert key_for("x").subkey("p") != generator_for("x").bytes(32)
    assert bits_for(256, "x").tobytes() != generator_for("x").integers(0, 2, 256, dtype=np.uint8).tobytes()


def test_payload_bits_are_even():
    ones = bits_for(100_000, "many")
    assert set(ones) == {0, 1}
    assert ones.dtype == np.uint8
    assert abs(ones.mean() - 0.5) < 5 * 0.5 / np.sqrt(len(ones))
