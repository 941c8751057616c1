"""Run the commands of docs/gallery.md on the included hare and on shapes made here, and write page and pictures.

.venv/bin/python tools/make_gallery.py

A key of 32 zero bytes takes the place of one that `keygen` makes. Pictures go to docs/images/gallery as JPEG.
"""

from __future__ import annotations

import contextlib
import io
import shlex
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

import meshmark as mm
from meshmark.cli.main import main as meshmark
from meshmark.data import hare_ply

ROOT = Path(__file__).resolve().parents[1]
PAGE, IMAGES = ROOT / "docs" / "gallery.md", ROOT / "docs" / "images" / "gallery"
WIDTH, QUALITY, MOST_LINES = 1500, 82, 8
HEAD = """# Gallery

Made by `make gallery` from runs of the commands below, with a key of 32 zero bytes; do not edit. The hare is
included, the other shapes are made by formula.
"""


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A picture: its name, heading, alternative text, a sentence, and the commands that end in `NAME.png`."""

    name: str
    title: str
    alt: str
    words: str
    commands: tuple[str, ...]


SCENES = (
    Scene(
        name="mark",
        title="A mark, and what is seen of it",
        alt="The original hare, the marked one, and how far the mark turns its normals",
        words="Shading shows how a surface is turned. The mark goes where the surface's own detail hides it.",
        commands=("embed hare.ply marked.ply --key my.key --id 0123456789abcdef --picture mark.png",),
    ),
    Scene(
        name="displacement",
        title="How far the surface moved",
        alt="The marked hare, coloured by its distance from the original",
        words="The mark lies on all of the surface: any large enough part of it tells the id.",
        commands=("compare hare.ply marked.ply --picture displacement.png",),
    ),
    Scene(
        name="change",
        title="A change, found and undone",
        alt="The altered hare, its tamper map, and the recovered hare",
        words="A tenth of the points is pushed with a sculpting brush; finding and mending it takes the key alone.",
        commands=(
            "attack marked.ply edited.ply bump 0.1 --seed 9",
            "authenticate edited.ply --key my.key",
            "recover edited.ply recovered.ply --key my.key --picture change.png",
        ),
    ),
    Scene(
        name="deleted",
        title="A part that is gone",
        alt="The hare with a part deleted, its tamper map, and the recovered hare",
        words="A part is deleted, which leaves a hole; it is filled with what the miniature has of it.",
        commands=(
            "attack marked.ply holed.ply delete_part 0.1 --seed 21",
            "recover holed.ply filled.ply --key my.key --picture deleted.png",
        ),
    ),
    Scene(
        name="noise",
        title="A copy with noise",
        alt="A noisy copy of the marked hare, coloured by its distance from the marked one",
        words="Noise of 0.3 % of the mean distance from the centre; the id is still read with the key alone.",
        commands=(
            "attack marked.ply noisy.ply noise 0.003",
            "compare marked.ply noisy.ply --picture noise.png",
            "extract noisy.ply --key my.key",
        ),
    ),
    Scene(
        name="salient",
        title="Salient points",
        alt="The hare coloured by saliency, its salient points as dots",
        words="What stands out, at several scales ([the mathematics](design.md#2-saliency-nc-dgg-eq-1-6)).",
        commands=("saliency hare.ply --picture salient.png",),
    ),
    Scene(
        name="regions",
        title="Regions",
        alt="The hare in regions of equal area, beside its green and blue half",
        words="Regions of equal share of the green and the blue half, around salient points.",
        commands=("segment hare.ply --picture regions.png",),
    ),
    Scene(
        name="knot",
        title="A model with a texture",
        alt="A knotted rope with stripes: original, marked, and change of shading",
        words="A save keeps materials and texture coordinates; a smooth surface hides little, so it moves less.",
        commands=("embed knot.obj knot_marked.obj --key my.key --id 00000000000c0ffe --picture knot.png",),
    ),
    Scene(
        name="lowpoly",
        title="A low-poly model",
        alt="A rough stone of 302 points: original, marked, and change of shading",
        words="Triangles longer than a patch: points carry the id, sliding along the surface.",
        commands=(
            "embed stone.obj stone_marked.obj --key my.key --id 0000000000c0ffee --picture lowpoly.png",
            "extract stone_marked.obj --key my.key",
        ),
    ),
)  # fmt: skip


def write_knot(along: int = 700, around: int = 28) -> None:
    """Write knot.obj, its materials and its image: a tube around a trefoil knot that wears stripes."""
    t = 2.0 * np.pi * np.arange(along) / along
    middle = [
        np.sin(t) + 2.0 * np.sin(2.0 * t),
        1.15 * (np.cos(t) - 2.0 * np.cos(2.0 * t)),
        -0.9 * np.sin(3.0 * t),
    ]
    way = np.stack(middle, axis=1)
    ahead = np.roll(way, -1, axis=0) - np.roll(way, 1, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    side = np.cross(ahead, way + np.array([0.0, 0.0, 9.0]))
    side /= np.linalg.norm(side, axis=1)[:, None]
    up = np.cross(ahead, side)
    turn = 2.0 * np.pi * np.arange(around) / around
    radius = 0.5 + 0.12 * np.sin(t + 0.7)
    ring = np.cos(turn)[None, :, None] * side[:, None] + np.sin(turn)[None, :, None] * up[:, None]
    points = (way[:, None] + radius[:, None, None] * ring).reshape(-1, 3)
    lines = ["mtllib knot.mtl", *(f"v {x:.7f} {y:.7f} {z:.7f}" for x, y, z in points)]
    lines += [
        f"vt {30 * i / along:.6f} {j / around:.6f}" for i in range(along + 1) for j in range(around + 1)
    ]
    lines.append("usemtl rope")
    for i, j in np.ndindex(along, around):
        corners = ((i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j))
        named = (f"{p % along * around + q % around + 1}/{p * (around + 1) + q + 1}" for p, q in corners)
        lines.append("f " + " ".join(named))
    Path("knot.obj").write_text("\n".join([*lines, ""]))
    Path("knot.mtl").write_text("newmtl rope\nKd 1 1 1\nmap_Kd rope.png\n")
    column, row = np.meshgrid(np.arange(256), np.arange(256))
    stripe = ((column + row) // 64) % 4  # at a slant, and closed over both sides of the image
    colours = np.array([[214, 90, 49], [244, 226, 198], [38, 84, 124], [244, 226, 198]], np.uint8)
    Image.fromarray(colours[stripe]).save("rope.png")


def stone(count: int = 302) -> mm.Mesh:
    """Return a rough stone: points on a sphere with their hull's faces, each nearer or farther by chance."""
    from scipy.spatial import ConvexHull

    number = np.arange(count) + 0.5
    rise, turn = np.arccos(1.0 - 2.0 * number / count), np.pi * (1.0 + 5.0**0.5) * number
    unit = np.stack([np.cos(turn) * np.sin(rise), np.sin(turn) * np.sin(rise), np.cos(rise)], axis=1)
    faces = ConvexHull(unit).simplices.astype(np.int64)
    corners = unit[faces]
    outwards = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("fi,fi->f", outwards, corners[:, 0]) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    radius = 1.0 + 0.2 * unit[:, 0] + np.random.default_rng(4).normal(0.0, 0.07, count)
    return mm.Mesh(unit * radius[:, None] * [1.6, 1.2, 1.0], faces)


def printed(command: str) -> str:
    """Run a command in this folder and return what it prints on standard output."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        code = meshmark(shlex.split(command))
    if code not in (0, 1):
        raise SystemExit(f"meshmark {command}: exit code {code}")
    lines = out.getvalue().strip().splitlines()
    return "\n".join(lines if len(lines) <= MOST_LINES else [*lines[: MOST_LINES - 2], "    ..."])


def keep(scene: Scene) -> None:
    """Put the picture of a scene into the docs, as a JPEG of at most WIDTH pixels."""
    with Image.open(f"{scene.name}.png") as picture:
        small = picture.convert("RGB")
    small.thumbnail((WIDTH, WIDTH))
    IMAGES.mkdir(parents=True, exist_ok=True)
    small.save(IMAGES / f"{scene.name}.jpg", quality=QUALITY, optimize=True)


def main() -> None:
    """Write docs/gallery.md and its pictures."""
    parts = [HEAD]
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        Path("hare.ply").write_bytes(hare_ply())
        write_knot()
        mm.write_mesh(stone(), "stone.obj")
        mm.Key(bytes(32)).save("my.key")
        for scene in SCENES:
            steps = "\n\n".join(f"$ meshmark {each}\n{printed(each)}".strip() for each in scene.commands)
            keep(scene)
            picture = f"![{scene.alt}](images/gallery/{scene.name}.jpg)"
            parts.append(f"## {scene.title}\n\n{scene.words}\n\n{picture}\n\n```console\n{steps}\n```\n")
    PAGE.write_text("\n".join(parts), encoding="utf-8")


if __name__ == "__main__":
    main()
