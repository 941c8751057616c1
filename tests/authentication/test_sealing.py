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


def test_what_was_sealed_opens_with_the_key_alone():
    sealed = seal(TEXT, KEY)
    assert len(sealed) == len(TEXT) + TAG_BYTES
    assert open_sealed(sealed, KEY) == TEXT
    assert seal(TEXT, KEY) == sealed
    assert TEXT[:32] not in sealed
    with pytest.raises(InputError, match="another key"):
        open_sealed(sealed, Key(bytes(32)))


@pytest.mark.parametrize("place", [0, TAG_BYTES - 1, TAG_BYTES, -1])
def test_a_changed_bit_is_seen(place):
    sealed = bytearray(seal(TEXT, KEY))
    sealed[place] ^= 1
    with pytest.raises(InputError, match="was changed"):
        open_sealed(bytes(sealed), KEY)


@pytest.mark.parametrize("length", [0, 1, TAG_BYTES - 1, TAG_BYTES])
def test_what_is_too_short_is_refused(length):
    with pytest.raises(InputError, match="was changed"):
        open_sealed(bytes(length), KEY)


def test_it_is_the_library_s_aes_siv_under_an_expanded_sub_key():
    expanded = HKDFExpand(SHA256(), 64, b"meshmark AES-SIV").derive(KEY.subkey("undo seal"))
    assert AESSIV(expanded).decrypt(seal(TEXT, KEY), None) == TEXT


def test_the_library_is_imported_only_to_seal_or_open():
    code = (
        "import sys, meshmark; meshmark.embed, meshmark.extract, meshmark.unmark; import meshmark.cli.main\n"
        "assert not [name for name in sys.modules if name.startswith('cryptography')]"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
