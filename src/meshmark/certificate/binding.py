"""What binds a certificate to its content, and to the key and the id that it was made with.

`content` authenticates every other field of the certificate, so that an edited one is known; `key` and `mark`
are digests of it with the key, and with key and id; `id` is the id, sealed: with the key this id is looked for
besides all others, which takes far less evidence than any of 2^64. Without the key all four are random numbers
of one length that differ from certificate to certificate, so it stays safe to hand out. Certificates that were
made before ids were sealed have none.
"""

from __future__ import annotations

import hmac
from dataclasses import replace
from hashlib import blake2b
from typing import Any

from meshmark.certificate.certificate import Certificate
from meshmark.certificate.sealing import open_sealed, seal
from meshmark.coding.keys import Key
from meshmark.errors import InputError

__all__ = ["FIELD", "bound", "mismatch", "refuse_edited", "stated_id"]

FIELD = "binding"
"""Name of the certificate's field."""
_PURPOSE = "certificate binding"
_BYTES = 16
_SEAL, _ID_BYTES = "certificate id seal", 16
# Fields that verdicts depend on.
_SAID = ("layers", "written")


def bound(certificate: Certificate, key: Key, identity: int) -> Certificate:
    """Return the certificate of a model that was marked with this key and id, bound to both.

    Fields that are added or changed after this break the binding.
    """
    content = _content(certificate, key)
    value = {
        "content": content,
        "key": _of_key(content, key),
        "mark": _of_mark(content, key, identity),
        "id": seal(identity.to_bytes(_ID_BYTES, "little"), key, _SEAL, bound_to=_text(content)).hex(),
    }
    return replace(certificate, more={**certificate.more, FIELD: value})


def refuse_edited(certificate: Certificate, key: Key) -> None:
    """Raise `InputError` where a certificate that was made with this key is not as it was made."""
    value = certificate.more.get(FIELD)
    if not isinstance(value, dict) or not _made_with(value, key):
        return  # nothing can be said of certificates of other keys
    intact = _agrees(value.get("content"), _content(certificate, key))
    if not intact or ("id" in value and _opened(value, key) is None):
        raise InputError("the certificate was edited after it was made, expected the file that `embed` wrote")


def stated_id(certificate: Certificate, key: Key) -> int | None:
    """Return the id of the mark that a certificate was made for.

    None where another key made it, where it has none, or where it was changed. Other fields are not looked at: see
    `refuse_edited`.
    """
    value = certificate.more.get(FIELD)
    return _opened(value, key) if isinstance(value, dict) and _made_with(value, key) else None


def mismatch(certificate: Certificate, key: Key, identity: int | None) -> str | None:
    """Return why a certificate does not belong to a mark.

    Parameters
    ----------
    certificate : Certificate
    key : Key
        Of the mark.
    identity : int or None
        Of the mark, as `coding.message` counts ids; None: any mark of this key.

    Returns
    -------
    str or None
        A sentence for the reader, None where the certificate belongs to the mark.
    """
    value = certificate.more.get(FIELD)
    if not isinstance(value, dict):
        return "The certificate is not bound to any key, as those are that are made with a mark."
    if not _made_with(value, key):
        return "The certificate was made with another key, or its binding was changed."
    if identity is not None and not _agrees(value.get("mark"), _of_mark(value["content"], key, identity)):
        return "The certificate is that of another mark: of another model, or of a copy with another id."
    return None


def _made_with(value: dict[str, Any], key: Key) -> bool:
    content = value.get("content")
    return isinstance(content, str) and _agrees(value.get("key"), _of_key(content, key))


def _opened(value: dict[str, Any], key: Key) -> int | None:
    """Return the id that is sealed in the value, None where it was changed."""
    try:
        sealed = bytes.fromhex(value["id"])
        return int.from_bytes(open_sealed(sealed, key, _SEAL, bound_to=_text(value["content"])), "little")
    except (InputError, KeyError, TypeError, ValueError):
        return None


def _agrees(stated: object, right: str) -> bool:
    return isinstance(stated, str) and hmac.compare_digest(_text(stated), _text(right))


def _content(certificate: Certificate, key: Key) -> str:
    return _digest(certificate.canonical(without=FIELD), key, b"content")


def _of_key(content: str, key: Key) -> str:
    return _digest(_text(content), key, b"key")


def _of_mark(content: str, key: Key, identity: int) -> str:
    return _digest(
        identity.to_bytes(8 if identity < 1 << 64 else 16, "little") + _text(content), key, b"mark"
    )


def _text(value: str) -> bytes:
    return value.encode("utf-8", "surrogatepass")  # JSON may hold any code point


def _digest(text: bytes, key: Key, use: bytes) -> str:
    return blake2b(text, digest_size=_BYTES, key=key.subkey(_PURPOSE), person=use).hexdigest()
