"""What a file shows otherwise than its surface, beside what it showed when it was signed off.

A deviation (`document.Deviation`) that was there when the model was marked is no change. What was there is kept in
the payload and in the certificate: two bytes a deviation, its kind and its amount on a logarithmic scale.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from hashlib import blake2b
from math import ceil, log2
from typing import Any, Final

from meshmark.certificate.certificate import Certificate
from meshmark.coding.keys import Key
from meshmark.document import KINDS, Deviation, Document

__all__ = ["FIELD", "Cause", "causes_of", "packed_deviations", "with_shown"]

FIELD: Final = "shown"
"""Name of the certificate's field: `deviations` in hexadecimal, and `looks`, keyed digests, if read."""
# Amounts from 2^-13 to 2^2.9 in sixteenths of an octave; what exports round stays within two of them.
_LOWEST, _STEPS, _WITHIN = -13.0, 16.0, 2
# A deviation below this is rounding: of displacements over the diagonal, of shares, of lengths.
_LEAST: Final = {"morph_weights": 1e-4, "skin": 5e-4}
_PURPOSE, _BYTES = "looks of a model", 8
_SENTENCES: Final = {
    "morph_weights": "its morph weights displace the surface by {percent} of the diagonal",
    "skin": "its skin is not at rest and displaces the surface by {percent} of the diagonal",
    "scene": "its default scene leaves out {percent} of the faces",
    "instancing": "GPU instances show it several times or elsewhere",
    "lines": "lines are drawn beside the surface",
    "points": "points are drawn beside the surface",
    "hidden_material": "materials hide {percent} of the faces",
    "hidden_node": "nodes that are not visible hide {percent} of the faces",
    "levels_of_detail": "other levels of detail may be shown instead",
    "morph_animation": "an animation of morph weights deforms it",
    "skeletal_animation": "an animation of its skeleton deforms it",
    "node_animation": "an animation moves its parts",
    "pointer_animation": "an animation changes other properties",
    "looks": "its materials or images are not those that it was signed off with",
}


@dataclass(frozen=True, kw_only=True)
class Cause:
    """Why a file shows something else than what was signed off.

    kind: of `document.KINDS`, or "looks" for materials and images. amount: see `document.Deviation`; 1 of looks.
    """

    kind: str
    amount: float

    @property
    def sentence(self) -> str:
        """Return a clause for the reader."""
        share = f"{100.0 * self.amount:.2g} %" if self.amount < 0.995 else f"{100.0 * self.amount:.0f} %"
        return _SENTENCES[self.kind].format(percent=share)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON fields."""
        return {"kind": self.kind, "amount": self.amount, "sentence": self.sentence}


def packed_deviations(document: Document | None) -> bytes:
    """Return two bytes for each deviation of a file above half of what counts; none for a mesh without a file."""
    found = () if document is None else document.deviations()
    large = [each for each in found if each.amount > 0.5 * _LEAST.get(each.kind, 0.0)]
    return b"".join(bytes([KINDS.index(each.kind), _level(each.amount)]) for each in large)


def with_shown(certificate: Certificate, document: Document | None, key: Key) -> Certificate:
    """Return the certificate with what a marked file shows otherwise, and its looks; unchanged without a file."""
    if document is None:
        return certificate
    value: dict[str, Any] = {"deviations": packed_deviations(document).hex()}
    looks = document.looks()
    if looks is not None:
        value["looks"] = _digests(looks, key)
    return replace(certificate, more={**certificate.more, FIELD: value})


def causes_of(
    document: Document | None, key: Key, signed: bytes | None, certificate: Certificate | None
) -> tuple[Cause, ...]:
    """Return why a file shows something else than what was signed off.

    Parameters
    ----------
    document : Document or None
        The suspect's file.
    key : Key
        That the certificate was made with.
    signed : bytes or None
        The deviations that the payload reports; None where it could not be read.
    certificate : Certificate or None
        The model's own, or None.

    Returns
    -------
    tuple of Cause
        None of a mesh without a file. Without payload and certificate every deviation is a cause.
    """
    if document is None:
        return ()
    more = None if certificate is None else certificate.more.get(FIELD)
    kept: Mapping[str, Any] = more if isinstance(more, dict) else {}
    allowed = _levels(signed or b"") | _levels(_bytes(kept.get("deviations")))
    causes = [
        Cause(kind=each.kind, amount=each.amount)
        for each in document.deviations()
        if each.amount > _LEAST.get(each.kind, 0.0) and not _is_signed(each, allowed)
    ]
    looks, known = document.looks(), kept.get("looks")
    if (
        looks is not None
        and isinstance(known, list)
        and not set(_digests(looks, key)) <= set(map(str, known))
    ):
        causes.append(Cause(kind="looks", amount=1.0))
    return tuple(causes)


def _is_signed(found: Deviation, allowed: Iterable[tuple[int, int]]) -> bool:
    kind, level = KINDS.index(found.kind), _level(found.amount)
    return any(kind == other and abs(level - signed) <= _WITHIN for other, signed in allowed)


def _level(amount: float) -> int:
    return min(max(ceil(_STEPS * (log2(max(amount, 1e-30)) - _LOWEST)), 0), 255)


def _levels(packed: bytes) -> frozenset[tuple[int, int]]:
    return frozenset(zip(packed[::2], packed[1::2], strict=False))


def _bytes(text: object) -> bytes:
    try:
        return bytes.fromhex(text) if isinstance(text, str) else b""
    except ValueError:
        return b""


def _digests(looks: Iterable[str], key: Key) -> list[str]:
    secret = key.subkey(_PURPOSE)
    return sorted(blake2b(word.encode(), digest_size=_BYTES, key=secret).hexdigest() for word in looks)
