"""What an embedding is asked for, checked before anything is computed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from meshmark.authentication.payload.content import Asked, Content, content_of
from meshmark.coding.keys import Key
from meshmark.coding.message import ID_BITS, requested_id
from meshmark.errors import InputError
from meshmark.strengths import check_strength

__all__ = ["LAYERS", "WEB_FORMATS", "MarkRequest"]

LAYERS: Final = ("both", "ownership", "authentication")
WEB_FORMATS: Final = ("glb", "gltf")
"""Files that web pipelines round: their marks bear it where there is room, unless another tolerance is named."""


@dataclass(frozen=True, kw_only=True)
class MarkRequest:
    """The arguments of `embed`, checked, with the payload's file read and the id drawn.

    id: of so many bits, as `coding.message` counts them. layers: one of `LAYERS`, None for both where they fit.
    tolerance: as in `precisions_of`. optional: the authentication layer may be left out where it does not fit.
    web_first: the tolerance "web" is tried first. unseen: marks of authentication that are seen on more of the
    surface than `SHOWN_SHARES` get shorter words, and are refused where the shortest are seen, too. shown: how the
    model's file shows something else than its surface (`shown_otherwise.packed_deviations`).
    """

    key: Key
    id: int
    bits: int
    strength: str
    layers: str | None
    content: Asked
    tolerance: str | None
    optional: bool
    web_first: bool = False
    unseen: bool = False
    shown: bytes = b""

    @classmethod
    def checked(
        cls,
        key: Key,
        *,
        id: int | None,
        bits: int = ID_BITS,
        strength: str,
        layers: str | None,
        payload: Content,
        tolerance: str | None,
    ) -> MarkRequest:
        """Return the request that these arguments of `embed` make; raises `InputError` where they make none."""
        check_strength(strength)
        if layers is not None and layers not in LAYERS:
            raise InputError(f"unknown layers '{layers}', expected one of {', '.join(LAYERS)}")
        content = content_of(payload)
        identity = requested_id(id, bits)
        if layers == "ownership" and tolerance is not None:
            raise InputError(
                "a tolerance is one of authentication marks, expected layers both or authentication"
            )
        if layers == "ownership" and payload is not None and content.kind != "none":
            raise InputError(
                "a payload needs the authentication layer, expected layers both or authentication"
            )
        if bits != ID_BITS:
            asked = layers not in (None, "ownership") or tolerance is not None
            if asked or (payload is not None and content.kind != "none"):
                raise InputError(
                    f"marks of authentication are signed with an id of {ID_BITS} bits, expected no layers, payload "
                    f"or tolerance of theirs with {bits} bits"
                )
        return cls(
            key=key,
            id=identity,
            bits=bits,
            strength=strength,
            layers=layers,
            content=content,
            tolerance=tolerance,
            optional=layers is None and payload is None and tolerance is None,
        )
