"""The table of attacks (docs/design.md, section 10). Strengths are those of the benchmark, mildest first."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

from meshmark.attacks.attack import Attack, Function, Need
from meshmark.attacks.crop import crop
from meshmark.attacks.files import through_file
from meshmark.attacks.local_add import add_part
from meshmark.attacks.local_delete import delete_part
from meshmark.attacks.local_move import move_part, scale_part
from meshmark.attacks.local_relief import bump, dent
from meshmark.attacks.local_replace import replace_part
from meshmark.attacks.local_smooth import smooth_part
from meshmark.attacks.noise import gaussian, noise
from meshmark.attacks.numbering import shuffle, unweld, weld
from meshmark.attacks.paste import paste
from meshmark.attacks.protocol import collusion, copy, second_mark
from meshmark.attacks.remeshing import remeshing
from meshmark.attacks.rounding import float32, quantisation
from meshmark.attacks.simplification import simplification
from meshmark.attacks.smoothing import smoothing, smoothing_half, taubin
from meshmark.attacks.subdivision import loop, midpoint, sqrt3
from meshmark.attacks.transforms import affine, mirror, similarity
from meshmark.attacks.voxels import voxels
from meshmark.errors import InputError

__all__ = ["ATTACKS", "find_attack"]


class _Scale(NamedTuple):
    """What a strength counts, and the strengths other than 0 that there are."""

    unit: str
    lowest: float = 0.0
    highest: float = inf
    whole: bool = False


_AMPLITUDE = _Scale("share of the mean vertex-centroid distance")
_PASSES = _Scale("passes", 1, 10_000, True)
_BITS = _Scale("bits per coordinate", 1, 52, True)
_POINTS = _Scale("share of the points", 0.0, 1.0)
_VERTICES = _Scale("share of the vertices", 0.0, 1.0)
_FACES = _Scale("share of the faces", 0.0, 1.0)
_LEVELS = _Scale("levels", 1, 10, True)
_EDGE = _Scale("mean edge lengths", 0.2, 5.0)
_VOXELS = _Scale("voxels along the longest side", 4, 512, True)
_AMOUNT = _Scale("share of any rotation, scale 0.1 to 10, shift by a diagonal", 0.0, 1.0)
_STRETCH = _Scale("share more along one axis, less along another", 0.0, 0.99)
_MODELS = _Scale("models in the average, this one included", 2, 1000, True)
_ESTIMATE = _Scale("share of the mark that the donor seems to have")
_ONCE = _Scale("times", 1, 1)


def _row(
    function: Function, strengths: tuple[float, ...], scale: _Scale, imitates: str, needs: Need = ""
) -> Attack:
    return Attack(function=function, strengths=strengths, imitates=imitates, needs=needs, **scale._asdict())


_PARTS = (0.01, 0.05, 0.1, 0.2)
_NOISE = (0.0005, 0.001, 0.003, 0.005, 0.01, 0.02, 0.05)
_FORMAT = "export to {} and import again"

# fmt: off
ATTACKS: dict[str, Attack] = {
    "noise": _row(noise, _NOISE, _AMPLITUDE, "scanner noise, or jitter added to drown the mark"),
    "gaussian": _row(gaussian, (0.01, 0.02, 0.05), _AMPLITUDE, "heavier noise with tails, as in the paper"),
    "smoothing": _row(smoothing, (5, 10, 15, 30, 50), _PASSES, "a gentle smoothing tool (lambda 0.1)"),
    "smoothing_half": _row(smoothing_half, (5, 10, 15), _PASSES, "a strong smoothing tool (lambda 0.5)"),
    "taubin": _row(taubin, (5, 10, 20), _PASSES, "clean-up of scans without shrinking (0.5, -0.53)"),
    "quantisation": _row(quantisation, (16, 12, 11, 10, 9, 8, 7), _BITS, "compressed files (Draco, meshopt)"),
    "crop": _row(crop, (0.03, 0.06, 0.09, 0.1, 0.3, 0.5, 0.7), _VERTICES, "a part cut off by a plane"),
    "simplification": _row(simplification, (0.1, 0.3, 0.5, 0.7, 0.9, 0.95), _FACES, "fewer faces for a game"),
    "midpoint": _row(midpoint, (1, 2), _LEVELS, "more faces, the same surface"),
    "loop": _row(loop, (1, 2), _LEVELS, "a smooth subdivision surface (Loop)"),
    "sqrt3": _row(sqrt3, (1, 2), _LEVELS, "a smooth subdivision surface (sqrt 3)"),
    "remeshing": _row(remeshing, (0.7, 1, 1.5, 2), _EDGE, "even triangles from a sculpting program"),
    "voxels": _row(voxels, (256, 128, 64), _VOXELS, "a solid made anew for printing, a scan fused again"),
    "similarity": _row(similarity, (1,), _AMOUNT, "turned, scaled and moved in an editor, other units"),
    "affine": _row(affine, (0.01, 0.02, 0.03, 0.05), _STRETCH, "stretched a little in an editor"),
    "mirror": _row(mirror, (1,), _ONCE, "mirrored in an editor, a left-handed importer"),
    "shuffle": _row(shuffle, (1,), _ONCE, "vertex and face order of another program"),
    "float32": _row(float32, (1,), _ONCE, "single precision, as graphics cards hold positions"),
    "weld": _row(weld, (1,), _ONCE, "merge of coincident vertices on import"),
    "unweld": _row(unweld, (1,), _ONCE, "split into separate triangles, flat shading"),
    "file_off": _row(through_file("off"), (1,), _ONCE, _FORMAT.format("OFF with 6 significant digits")),
    "file_obj": _row(through_file("obj"), (1,), _ONCE, _FORMAT.format("OBJ with 6 decimals")),
    "file_ply": _row(through_file("ply"), (1,), _ONCE, _FORMAT.format("PLY in single precision")),
    "file_stl": _row(through_file("stl"), (1,), _ONCE, _FORMAT.format("STL with its separate triangles")),
    "file_glb": _row(through_file("glb"), (1,), _ONCE, _FORMAT.format("binary glTF")),
    "file_gltf": _row(through_file("gltf"), (1,), _ONCE, _FORMAT.format("glTF")),
    "file_3mf": _row(through_file("3mf"), (1,), _ONCE, _FORMAT.format("3MF with 6 decimals")),
    "bump": _row(bump, _PARTS, _POINTS, "a bump raised with a sculpting brush"),
    "dent": _row(dent, _PARTS, _POINTS, "a dent pressed with a sculpting brush"),
    "move_part": _row(move_part, _PARTS, _POINTS, "a limb put into another pose"),
    "scale_part": _row(scale_part, _PARTS, _POINTS, "a part made larger"),
    "smooth_part": _row(smooth_part, _PARTS, _POINTS, "a part gone over with a smoothing brush"),
    "add_part": _row(add_part, _PARTS, _POINTS, "a part put on, not sewn"),
    "delete_part": _row(delete_part, _PARTS, _POINTS, "a part deleted, which leaves a hole"),
    "replace_part": _row(replace_part, _PARTS, _POINTS, "a part sculpted anew"),
    "paste": _row(paste, _PARTS, _POINTS, "a part cut from another marked model and pasted in", "donor"),
    "second_mark": _row(second_mark, (1,), _ONCE, "somebody else marks the model, too", "embed"),
    "collusion": _row(collusion, (2, 3, 5), _MODELS, "buyers average their differently marked copies", "copies"),
    "copy": _row(copy, (0.5, 1, 2), _ESTIMATE, "a mark lifted off one model and put on another", "donor"),
}
# fmt: on


def find_attack(name: str) -> Attack:
    """Return an attack by its name.

    Parameters
    ----------
    name : str
        A key of `ATTACKS`.

    Returns
    -------
    Attack
        The entry of the table.

    Raises
    ------
    InputError
        There is no such attack; the message lists the names there are.
    """
    if name not in ATTACKS:
        raise InputError(f"'{name}' is not an attack, expected one of {', '.join(ATTACKS)}")
    return ATTACKS[name]
