"""Why marks of authentication that were made are not taken; others may hold."""

from __future__ import annotations

from meshmark.errors import CapacityError, MeshmarkError
from meshmark.marking.promises import Broken

__all__ = ["BrokenError", "IdLostError", "SeenError", "UnplacedError", "UnreadError"]


class UnreadError(CapacityError):
    """The marks of authentication, or the id below them, are not read back as they should; others may be."""


class IdLostError(UnreadError):
    """The marks move points too much for the layer below."""


class UnplacedError(UnreadError):
    """The marks hold, but do not tell where the model lies, so that the payload bound to places is not read."""


class BrokenError(UnreadError):
    """A rounding that the tolerance promises to bear leaves points without a mark, as `broken` says."""

    def __init__(self, broken: Broken) -> None:
        super().__init__(
            f"the marks of authentication would not survive {broken.called}, as the tolerance promises"
        )
        self.broken = broken


class SeenError(MeshmarkError):
    """Marks that must not be seen are, on this share of the surface, and those of shorter words would be, too.

    No `CapacityError`, after which others of the same tolerance are tried.
    """

    def __init__(self, share: float) -> None:
        super().__init__(f"the marks of authentication would be seen on {share:.0%} of the surface")
        self.share = share
