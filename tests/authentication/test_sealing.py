from __future__ import annotations

import subprocess
import sys

import pytest
from cryptography.hazmat.primitives.ciphers.aead import AESSIV
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.kdf.hkdf import HKDFExpand

from meshmark.certificate.sealing import TAG_BYTES, open_sealed, seal
from meshmark.coding.keys import Key
from meshmark.errors import InputError
from tests.keys import KEY

TEXT = bytes(range(256)) * 3 + b"end"
PURPOSE = "a seal for tests"


def test_what_was_sealed_opens_with_the_key_alone():
    sealed = seal(TEXT, KEY, PURPOSE)
    assert len(sealed) == len(TEXT) + TAG_BYTES
    assert open_sealed(sealed, KEY, PURPOSE) == TEXT
    assert seal(TEXT, KEY, PURPOSE) == sealed
    assert TEXT[:32] not in sealed
    with pytest.raises(InputError, match="another key"):
        open_sealed(sealed, Key(bytes(32)), PURPOSE)


def test_what_it_is_bound_to_has_to_be_given_again_and_so_has_the_purpose():
    sealed = seal(TEXT, KEY, PURPOSE, bound_to=b"one")
    assert open_sealed(sealed, KEY, PURPOSE, bound_to=b"one") == TEXT
    assert sealed != seal(TEXT, KEY, PURPOSE, bound_to=b"other")
    for purpose, other in ((PURPOSE, b"other"), (PURPOSE, b""), ("another", b"one")):
        with pytest.raises(InputError, match="was changed"):
            open_sealed(sealed, KEY, purpose, bound_to=other)


@pytest.mark.parametrize("place", [0, TAG_BYTES - 1, TAG_BYTES, -1])
def test_a_changed_bit_is_seen(place):
    sealed = bytearray(seal(TEXT, KEY, PURPOSE))
    sealed[place] ^= 1
    with pytest.raises(InputError, match="was changed"):
        open_sealed(bytes(sealed), KEY, PURPOSE)


@pytest.mark.parametrize("length", [0, 1, TAG_BYTES - 1, TAG_BYTES])
def test_what_is_too_short_is_refused(length):
    with pytest.raises(InputError, match="was changed"):
        open_sealed(bytes(length), KEY, PURPOSE)


def test_it_is_the_library_s_aes_siv_under_an_expanded_sub_key():
    expanded = HKDFExpand(SHA256(), 64, b"meshmark AES-SIV").derive(KEY.subkey(PURPOSE))
    assert AESSIV(expanded).decrypt(seal(TEXT, KEY, PURPOSE), None) == TEXT


def test_the_library_is_imported_only_to_seal_or_open():
    code = (
        "import sys, meshmark; meshmark.embed, meshmark.extract, meshmark.unmark; import meshmark.cli.main\n"
        "assert not [name for name in sys.modules if name.startswith('cryptography')]"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
