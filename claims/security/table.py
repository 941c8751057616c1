"""What an attack measured, beside what it is held to, as a table in Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Figure", "table"]


@dataclass(frozen=True, kw_only=True)
class Figure:
    """One row: what was measured, of how many, the bar in words, and whether it is met; None: it has no bar."""

    name: str
    measured: str
    of: str
    bar: str = ""
    met: bool | None = None

    def __str__(self) -> str:
        return f"{self.name}: {self.measured} ({self.of})"


def table(figures: Sequence[Figure]) -> str:
    """Return the rows as Markdown."""
    lines = ["| figure | measured | of | bar | met |", "|---|---|---|---|---|"]
    words = {None: "", True: "yes", False: "**no**"}
    lines += [f"| {row.name} | {row.measured} | {row.of} | {row.bar} | {words[row.met]} |" for row in figures]
    return "\n".join(lines)
