"""Loops and conditions of tests that must not be empty: what is asserted in them is counted."""

from __future__ import annotations

from collections.abc import Iterable
from types import TracebackType
from typing import Self, TypeVar

Thing = TypeVar("Thing")


def some(things: Iterable[Thing], least: int = 1) -> list[Thing]:
    """Return the things to loop over, as a list; fails where there are fewer than `least` of them."""
    found = list(things)
    assert len(found) >= least, f"{len(found)} things to look at, expected {least} at least"
    return found


class Share:
    """Counts the cases tried and those in which a conditional assertion ran.

    A context manager: where less than the stated share of the cases got as far as their assertions, its
    end fails. Every case calls `case()`, and `asserted()` beside the assertions that it may not reach:

        with Share(0.3) as share:
            for text in texts:
                share.case()
                if condition(text):
                    share.asserted()
                    assert ...

    With hypothesis, the property is a function inside the `with` block and called there.
    """

    def __init__(self, least: float) -> None:
        assert 0.0 < least <= 1.0, f"a share of {least} says nothing, expected more than 0 and at most 1"
        self.least, self.cases, self.reached = least, 0, 0

    def case(self) -> None:
        """Count a case that was tried."""
        self.cases += 1

    def asserted(self) -> None:
        """Count a case that reached its assertions."""
        self.reached += 1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, _: object, __: TracebackType | None) -> None:
        if kind is None:
            assert self.cases, "no case was tried"
            assert self.reached >= self.least * self.cases, (
                f"asserted in {self.reached} of {self.cases} cases, expected {self.least:.0%} at least"
            )
