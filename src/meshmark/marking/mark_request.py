"""What an embedding is asked for, checked before anything is computed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from meshmark.authentication.payload.content import Asked, Content, content_of
from meshmark.coding.keys import Key
from meshmark.coding.message import check_id, random_id
from meshmark.errors import InputError
from meshmark.strengths import check_strength

__all__ = ["LAYERS", "WEB_FORMATS", "MarkRequest"]

LAYERS: Final = ("both", "ownership", "authentication")
WEB_FORMATS: Final = ("glb", "gltf")
"""Files that web pipelines round: their marks bear it where there is room, unless another tolerance is named."""


@dataclass(frozen=True, kw_only=True)
class MarkRequest:
    """The arguments of `embed`, checked, with the payload's file read and the id drawn.

    layers: one of `LAYERS`, None for both where they fit. tolerance: as in `precisions_of`. optional: the
    authentication layer may be left out where it does not fit. web_first: the tolerance "web" is tried first.
    shown: how the model's file shows something else than its surface (`shown_otherwise.packed_deviations`).
    """

    key: Key
    id: int
    strength: str
    layers: str | None
    content: Asked
    tolerance: str | None
    optional: bool
    web_first: bool = False
    shown: bytes = b""

    @classmethod
    def checked(
        cls,
        key: Key,
        *,
        id: int | None,
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
        identity = random_id() if id is None else check_id(id)
        if layers == "ownership" and tolerance is not None:
            raise InputError(
                "a tolerance is one of authentication marks, expected layers both or authentication"
            )
        if layers == "ownership" and payload is not None and content.kind != "none":
            raise InputError(
                "a payload needs the authentication layer, expected layers both or authentication"
            )
        return cls(
            key=key,
            id=identity,
            strength=strength,
            layers=layers,
            content=content,
            tolerance=tolerance,
            optional=layers is None and payload is None and tolerance is None,
        )
