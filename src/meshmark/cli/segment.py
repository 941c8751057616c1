"""`meshmark segment`: the map of regions."""

from __future__ import annotations

from meshmark.cli.model_input import named, read_model
from meshmark.cli.options import AsJson, Force, ModelFormatIn, ModelIn, Picture
from meshmark.cli.output import answer, described, plural
from meshmark.cli.paths import naming, staged
from meshmark.cli.progress import progress

__all__ = ["segment"]


def segment(
    model: ModelIn,
    picture: Picture = None,
    format: ModelFormatIn = None,
    force: Force = False,
    as_json: AsJson = False,
) -> int:
    """Split a model into regions.

    Each region lies around a salient point and has a fair share of the model's two halves, green and blue.
    """
    staging = staged([(picture, ".png")], [model], force)
    mesh = read_model(model, format, staging)
    from meshmark.segmentation import segment as part

    with progress("drawing the map"), naming(named(model)):
        result = part(mesh)
    if picture is not None:
        from meshmark.report.segmentation_picture import segmentation_picture

        with staging:
            segmentation_picture(mesh, result, picture, staging=staging)
    fields = described(result.to_dict(), model, {"picture": picture})
    lines = [f"{plural(len(fields['regions']), 'region')}; balance {fields['balance']:.3f} (1 is perfect)"]
    lines += [
        f"  {region['id']:>3}  green {100 * region['green_share']:5.1f} %  "
        f"blue {100 * region['blue_share']:5.1f} %  around vertex {region['salient_vertex']}"
        for region in fields["regions"]
    ]
    answer("\n".join(lines), fields, as_json)
    return 0
