"""The accounting of a search: every reading that is tried has a number, and pays for it in the bound."""

from __future__ import annotations

from math import inf
from time import monotonic

__all__ = ["OutOfTimeError", "TrialCounter"]


class OutOfTimeError(Exception):
    """The time that a search was given is over."""


class TrialCounter:
    """Numbers the trials of one search, and ends it when its time is over.

    The t-th trial is charged t (t + 1) hypotheses: as the 1 / (t (t + 1)) add up to 1, a union bound over all
    trials holds wherever the search stops.
    """

    def __init__(self, time_limit: float | None = None) -> None:
        """time_limit: seconds from now; None: no limit."""
        self._end = inf if time_limit is None else monotonic() + time_limit
        self._number = 0
        self._decoded, self._part = 0, 1

    def charge(self) -> float:
        """Begin the next trial and return the hypotheses that it is charged; raises `OutOfTimeError`."""
        if monotonic() > self._end:
            raise OutOfTimeError
        self._number += 1
        return float(self._number * (self._number + 1))

    def charge_decoding(self) -> float:
        """Count a reading that is decoded, and return what the chance of its word alone is charged.

        A lock is found without a look at the signs that make the word, so readings that are not decoded, and
        corrections within a lock, are no trials of the word. The d-th reading of the p-th part is charged
        p (p + 1) d (d + 1).
        """
        self._decoded += 1
        return float(self._part * (self._part + 1) * self._decoded * (self._decoded + 1))

    def begin_part(self) -> None:
        """Begin another part of the search, which does not pay for the readings of those before one by one."""
        self._part, self._decoded = self._part + 1, 0
