"""`meshmark compare`: how far apart two models are."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.cli.options import AsJson
from meshmark.cli.output import answer, percent

if TYPE_CHECKING:
    from meshmark.metrics import Comparison

__all__ = ["compare"]


def compare(
    a: Annotated[Path, typer.Argument(metavar="A", help="The model to compare with, such as the original.")],
    b: Annotated[Path, typer.Argument(metavar="B", help="The model to judge, such as the marked one.")],
    as_json: AsJson = False,
) -> int:
    """Measure how far apart two models are.

    Distances are between vertices of equal number, in shares of A's bounding-box diagonal.
    Models with different vertex counts have no vertex-by-vertex distance; JSON then says null.
    """
    from meshmark.io import read_mesh
    from meshmark.metrics import compare as measure

    first, second = read_mesh(a), read_mesh(b)
    result = measure(first, second)
    counts = len(first.vertices), len(second.vertices)
    answer(_words(result, counts), result.to_dict(), as_json)
    return 0


def _words(result: Comparison, counts: tuple[int, int]) -> str:
    if result.rms_over_diagonal is None or result.max_over_diagonal is None:
        return (
            f"A has {counts[0]:,} vertices and B has {counts[1]:,}: they cannot be compared vertex by vertex."
        )
    return "\n".join(
        (
            f"RMS distance      {percent(result.rms_over_diagonal)} of the diagonal",
            f"largest distance  {percent(result.max_over_diagonal)} of the diagonal",
            f"PSNR              {_decibels(result.psnr_db)}",
            f"PSNR, paper       {_decibels(result.paper_psnr_db)} (eq. 17, longest side scaled to 1)",
        )
    )


def _decibels(value: float | None) -> str:
    return "infinite" if value is None or value == float("inf") else f"{value:.2f} dB"
