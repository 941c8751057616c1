"""The keyed permutation of ids."""

from __future__ import annotations

import numpy as np

from meshmark.coding.codec import Codec
from meshmark.coding.keys import Key
from meshmark.coding.permutation import IdPermutation

RANDOM = np.random.default_rng(17)
KEY = Key(bytes(range(32)))
EDGES = [0, 1, 2**32 - 1, 2**32, 2**64 - 1]
IDS = EDGES + [int.from_bytes(RANDOM.bytes(8), "big") for _ in range(200)]


def test_every_id_comes_back():
    permutation = IdPermutation(KEY.subkey("id permutation"))
    images = [permutation.forward(identity) for identity in IDS]
    assert [permutation.backward(image) for image in images] == IDS
    assert len(set(images)) == len(set(IDS))
    assert min(images) >= 0
    assert max(images) < 2**64


def test_every_id_of_32_bits_comes_back():
    permutation = IdPermutation(KEY.subkey("id permutation"), 32)
    ids = [identity % 2**32 for identity in IDS]
    images = [permutation.forward(identity) for identity in ids]
    assert [permutation.backward(image) for image in images] == ids
    assert 0 <= min(images) <= max(images) < 2**32
    assert images != [IdPermutation(KEY.subkey("id permutation")).forward(each) for each in ids]


def test_another_key_gives_other_images():
    one, other = (IdPermutation(Key(bytes([n]) * 32).subkey("id permutation")) for n in (1, 2))
    images = [[permutation.forward(identity) for identity in IDS] for permutation in (one, other)]
    assert (np.array(images[0], dtype=np.uint64) != np.array(images[1], dtype=np.uint64)).all()


def test_neighbouring_ids_have_images_that_are_not_alike():
    """Half of the bits differ, give or take: the mean over 200 ids lies within 5 standard deviations of 32."""
    permutation = IdPermutation(KEY.subkey("id permutation"))
    differing = [bin(permutation.forward(one) ^ permutation.forward(one ^ 1)).count("1") for one in IDS]
    assert abs(np.mean(differing) - 32.0) < 5 * 4 / np.sqrt(len(IDS))


def test_the_sum_of_three_words_is_not_the_word_of_the_sum():
    codec = Codec(KEY)
    word = codec.encode(8) ^ codec.encode(9) ^ codec.encode(10)
    found = codec.decode(1.0 - 2.0 * word)
    assert found.id not in {8, 9, 10, 8 ^ 9 ^ 10}
