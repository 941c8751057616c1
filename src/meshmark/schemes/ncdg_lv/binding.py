"""What binds a certificate to the key and the id that it was made with, and tells a stranger by.

Keyed digests of the certificate's frame, one of them with the id, one with what the certificate says of the model
as it was written: without the key they are random numbers that differ from certificate to certificate, so it stays
safe to hand out.
"""

from __future__ import annotations

import hmac
import json
from dataclasses import replace
from hashlib import blake2b

import numpy as np

from meshmark.coding.keys import Key
from meshmark.schemes.ncdg_lv.certificate import Certificate

__all__ = ["FIELD", "bound", "stranger"]

FIELD = "binding"
"""Name of the certificate's field."""
_PURPOSE = "certificate binding"
_BYTES = 16
# Fields that verdicts depend on.
_SAID = ("layers", "written")


def bound(certificate: Certificate, key: Key, identity: int) -> Certificate:
    """Return the certificate of a model that was marked with this key and 64-bit id, bound to both."""
    value = {
        "key": _digest(certificate, key, b""),
        "mark": _digest(certificate, key, _bytes(identity)),
        "said": _digest(certificate, key, _said(certificate)),
    }
    return replace(certificate, more={**certificate.more, FIELD: value})


def stranger(certificate: Certificate, key: Key, identity: int | None) -> str | None:
    """Return a sentence where a certificate is not that of the mark with this id (None: of any of this key)."""
    value = certificate.more.get(FIELD)
    if not isinstance(value, dict):
        return "The certificate is not bound to any key, as those are that are made with a mark."
    if not _agrees(value.get("key"), _digest(certificate, key, b"")):
        return "The certificate was made with another key, or was changed."
    if "said" in value and not _agrees(value["said"], _digest(certificate, key, _said(certificate))):
        return "The certificate was changed since it was made."
    if identity is not None and not _agrees(value.get("mark"), _digest(certificate, key, _bytes(identity))):
        return "The certificate is that of another mark: of another model, or of a copy with another id."
    return None


def _agrees(told: object, right: str) -> bool:
    return isinstance(told, str) and hmac.compare_digest(told.encode(), right.encode())


def _said(certificate: Certificate) -> bytes:
    said = [certificate.more.get(name) for name in _SAID]
    return b"said " + json.dumps(said, sort_keys=True).encode()


def _bytes(identity: int) -> bytes:
    return identity.to_bytes(8, "little")


def _digest(certificate: Certificate, key: Key, text: bytes) -> str:
    frame = certificate.frame
    numbers = np.concatenate([frame.centre, [frame.scale, frame.area], frame.axes.ravel(), frame.moments])
    content = np.asarray(numbers, "<f8").tobytes() + text
    return blake2b(content, digest_size=_BYTES, key=key.subkey(_PURPOSE)).hexdigest()
