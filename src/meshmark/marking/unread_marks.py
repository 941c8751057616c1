"""Why marks of authentication that were made are not taken; others may hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshmark.errors import CapacityError

__all__ = ["BrokenError", "IdLostError", "UnplacedError", "UnreadError"]


class UnreadError(CapacityError):
    """The marks of authentication, or the id below them, are not read back as they should; others may be."""


class IdLostError(UnreadError):
    """The marks move points too much for the layer below."""


class UnplacedError(UnreadError):
    """The marks hold, but do not tell where the model lies, so that the payload bound to places is not read."""


class BrokenError(UnreadError):
    """A rounding that the tolerance promises to bear leaves points without a mark.

    unread: (p,) those points. passed: (p,) whose marks hold all the same.
    """

    def __init__(self, called: str, unread: NDArray[np.bool_], passed: NDArray[np.bool_]) -> None:
        super().__init__(f"the marks of authentication would not survive {called}, as the tolerance promises")
        self.unread, self.passed = unread, passed
