"""Bytes sealed for the owner of a key: encrypted and authenticated with AES-SIV (RFC 5297), by pyca `cryptography`.

AES-SIV needs no nonce: the same text under the same key gives the same bytes, as all of meshmark does, and nothing
else is lost by that. Its 512-bit key is expanded from a sub-key with HKDF (RFC 5869). The library is imported when
something is sealed or opened, so that other commands do not wait for it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from meshmark.coding.keys import Key
from meshmark.errors import InputError

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.ciphers.aead import AESSIV

__all__ = ["TAG_BYTES", "open_sealed", "seal"]

TAG_BYTES = 16
"""How much longer than the text its sealed form is."""
_KEY_BYTES = 64


def seal(text: bytes, key: Key, purpose: str, *, bound_to: bytes = b"") -> bytes:
    """Return the synthetic initialisation vector, which is also the tag, followed by the cipher text.

    purpose: of the sub-key. bound_to: data that is not sealed, but must be given again, unchanged, to open it.
    """
    return _cipher(key, purpose).encrypt(text, [bound_to] if bound_to else None)


def open_sealed(sealed: bytes, key: Key, purpose: str, *, bound_to: bytes = b"") -> bytes:
    """Return the text; raises `InputError` where the bytes were changed or sealed with another key."""
    from cryptography.exceptions import InvalidTag

    try:
        return _cipher(key, purpose).decrypt(sealed, [bound_to] if bound_to else None)
    except InvalidTag:
        raise InputError("the certificate's sealed data was changed or made with another key") from None


def _cipher(key: Key, purpose: str) -> AESSIV:
    from cryptography.hazmat.primitives.ciphers.aead import AESSIV
    from cryptography.hazmat.primitives.hashes import SHA256
    from cryptography.hazmat.primitives.kdf.hkdf import HKDFExpand

    expand = HKDFExpand(SHA256(), _KEY_BYTES, b"meshmark AES-SIV")
    return AESSIV(expand.derive(key.subkey(purpose)))
