"""`meshmark saliency`: where a surface stands out."""

from __future__ import annotations

from meshmark.cli.model_input import named, read_model
from meshmark.cli.options import AsJson, Force, ModelFormatIn, ModelIn, Picture
from meshmark.cli.output import answer, described, plural
from meshmark.cli.paths import naming, staged
from meshmark.cli.progress import progress

__all__ = ["saliency"]


def saliency(
    model: ModelIn,
    picture: Picture = None,
    format: ModelFormatIn = None,
    force: Force = False,
    as_json: AsJson = False,
) -> int:
    """Find where a surface stands out.

    Each vertex gets a saliency from 0 to 1; salient points are those that stand out most around them.
    """
    staging = staged([(picture, ".png")], [model], force)
    mesh = read_model(model, format, staging)
    from meshmark.saliency import analyse

    with progress("looking at the surface"), naming(named(model)):
        result = analyse(mesh)
    if picture is not None:
        from meshmark.report.saliency_picture import saliency_picture

        with staging:
            saliency_picture(mesh, result, picture, staging=staging)
    fields = described(result.to_dict(), model, {"picture": picture})
    points = fields["salient_points"]
    strongest = ", ".join(str(point["vertex"]) for point in sorted(points, key=lambda p: -p["beta"])[:5])
    words = f"{plural(len(points), 'salient point')} on {plural(fields['vertices'], 'vertex/vertices')}"
    answer(words + (f"; the strongest are vertices {strongest}" if points else ""), fields, as_json)
    return 0
