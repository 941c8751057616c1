"""`meshmark saliency`: where a surface stands out."""

from __future__ import annotations

from meshmark.cli.options import AsJson, ModelIn, Picture
from meshmark.cli.output import answer, plural
from meshmark.cli.paths import check_output, naming
from meshmark.cli.progress import progress

__all__ = ["saliency"]


def saliency(model: ModelIn, picture: Picture = None, as_json: AsJson = False) -> int:
    """Find where a surface stands out.

    Each vertex gets a saliency from 0 to 1; salient points are those that stand out most around them.
    """
    from meshmark.io import read_mesh

    if picture is not None:
        check_output(picture, [model], ".png")
    mesh = read_mesh(model)
    from meshmark.saliency import analyse

    with progress("looking at the surface"), naming(model):
        result = analyse(mesh)
    if picture is not None:
        from meshmark.report.saliency import saliency_picture

        saliency_picture(mesh, result, picture)
    fields = result.to_dict()
    points = fields["salient_points"]
    strongest = ", ".join(str(point["vertex"]) for point in sorted(points, key=lambda p: -p["beta"])[:5])
    words = f"{plural(len(points), 'salient point')} on {plural(fields['vertices'], 'vertex/vertices')}"
    answer(words + (f"; the strongest are vertices {strongest}" if points else ""), fields, as_json)
    return 0
