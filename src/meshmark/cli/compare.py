"""`meshmark compare`: how far apart two models are."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from meshmark.cli.model_input import named, read_model
from meshmark.cli.options import AsJson, Force, ModelFormatIn
from meshmark.cli.output import answer, described, percent
from meshmark.cli.paths import STANDARD_INPUT, naming, staged
from meshmark.errors import InputError

if TYPE_CHECKING:
    from meshmark.metrics import Comparison

__all__ = ["compare"]


def compare(
    a: Annotated[Path, typer.Argument(metavar="A", help="The model to compare with, such as the original.")],
    b: Annotated[Path, typer.Argument(metavar="B", help="The model to judge, such as the marked one.")],
    *,
    picture: Annotated[
        Path | None,
        typer.Option(metavar="OUT.png", help="Also draw A, B, and how far B is from A in % of the diagonal."),
    ] = None,
    format: ModelFormatIn = None,
    force: Force = False,
    as_json: AsJson = False,
) -> int:
    """Measure how far apart two models are.

    Vertices: distances between those of equal number, in shares of A's bounding-box diagonal; models with
    different counts have none, and JSON then says null.
    Surfaces: distances whatever the triangles, the larger of both directions. MSDM2: how visible the change is
    to one who knows A, 0 to 1. Normals: the mean angle between them at matched points.
    PSNR is that of the vertices, or where the counts differ, of the surfaces.
    """
    if a == b == STANDARD_INPUT:
        raise InputError(
            "only one of the two models can come from standard input, expected a file for the other"
        )
    staging = staged([(picture, ".png")], [a, b], force)
    piped = STANDARD_INPUT in (a, b)
    first, second = (
        read_model(path, None if piped and path != STANDARD_INPUT else format, staging) for path in (a, b)
    )
    from meshmark.metrics import compare as measure

    with naming(named(a), named(b)):
        result = measure(first, second)
        if picture is not None:
            from meshmark.report.displacement_picture import displacement_picture

            with staging:
                displacement_picture(first, second, picture, staging=staging)
    counts = len(first.vertices), len(second.vertices)
    answer(_words(result, counts), described(result.to_dict(), [a, b], {"picture": picture}), as_json)
    return 0


def _words(result: Comparison, counts: tuple[int, int]) -> str:
    lines = []
    if counts[0] != counts[1]:
        lines.append(
            f"A has {counts[0]:,} vertices and B has {counts[1]:,}: they cannot be compared vertex by vertex."
        )
    rows = (
        ("vertices, RMS", _share(result.rms_over_diagonal)),
        ("vertices, largest", _share(result.max_over_diagonal)),
        ("surfaces, RMS", _share(result.mrms_over_diagonal)),
        ("surfaces, largest", _share(result.hausdorff_over_diagonal)),
        ("PSNR", _decibels(result.psnr_db)),
        ("PSNR, paper", _decibels(result.paper_psnr_db, " (eq. 17, longest side scaled to 1)")),
        ("MSDM2, 0 to 1", _number(result.msdm2, ".3f")),
        ("normals, degrees", _number(result.normal_deviation_deg, ".3g")),
    )
    if result.mrms_over_diagonal is None:
        lines.append("A model has no surface: distances between surfaces are not defined.")
    return "\n".join([*lines, *(f"{name:18s} {words}" for name, words in rows if words)])


def _share(value: float | None) -> str:
    return "" if value is None else f"{percent(value)} of the diagonal"


def _decibels(value: float | None, remark: str = "") -> str:
    if value is not None and math.isinf(value):
        return "infinite"
    return _number(value, ".2f", " dB" + remark)


def _number(value: float | None, form: str, remark: str = "") -> str:
    return "" if value is None else f"{value:{form}}{remark}"
