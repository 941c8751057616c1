"""What a marked hare answers after a way through Blender: python tools/blender_roundtrip.py PYTHON.

PYTHON is one that has Blender as a module (`pip install bpy`). For each way the hare is marked in its format,
opened by Blender, edited, and exported with Blender's own defaults; the table of docs/blender.md is printed.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import meshmark as mm
from meshmark.data import hare_ply

HEAD = "| marked as | in Blender | exported as | id | `authenticate` |\n|---|---|---|---|---|"
ID = 0x0123456789ABCDEF
READ = {"ply": "bpy.ops.wm.ply_import", "obj": "bpy.ops.wm.obj_import", "stl": "bpy.ops.wm.stl_import"}
WRITE = {"ply": "bpy.ops.wm.ply_export", "obj": "bpy.ops.wm.obj_export", "stl": "bpy.ops.wm.stl_export"}
GLTF = {"glb": "bpy.ops.import_scene.gltf"}, {"glb": "bpy.ops.export_scene.gltf"}


@dataclass(frozen=True, kw_only=True)
class Way:
    """What is done in Blender: formats of the marked and of the exported file, Python that edits the object."""

    what: str
    read: str
    write: str
    edit: str = ""


def modifier(kind: str, **settings: object) -> str:
    """Return Python that adds a modifier and applies it."""
    lines = [f"bpy.ops.object.modifier_add(type='{kind}')", "made = bpy.context.object.modifiers[-1]"]
    lines += [f"made.{name} = {value!r}" for name, value in settings.items()]
    return "\n".join([*lines, "bpy.ops.object.modifier_apply(modifier=made.name)"])


TURNED = (
    "bpy.context.object.rotation_mode = 'XYZ'\n"
    "bpy.context.object.rotation_euler = (0.4, 1.1, 2.0)\n"
    "bpy.context.object.scale = (0.37, 0.37, 0.37)\n"
    "bpy.ops.object.transform_apply(location=True, rotation=True, scale=True)"
)
SCULPTED = (
    "top = max(v.co.length for v in bpy.context.object.data.vertices)\n"
    "for v in bpy.context.object.data.vertices:\n"
    "    if v.co.length > 0.93 * top: v.co *= 1.03"
)
STRETCHED = "for v in bpy.context.object.data.vertices: v.co.x *= 1.1"
WAYS = (
    Way(what="opened and exported", read="ply", write="ply"),
    Way(what="opened and exported", read="obj", write="obj"),
    Way(what="opened and exported", read="stl", write="stl"),
    Way(what="opened and exported", read="glb", write="glb"),
    Way(what="converted", read="ply", write="glb"),
    Way(what="converted", read="glb", write="obj"),
    Way(what="turned and scaled, applied", read="glb", write="glb", edit=TURNED),
    Way(what="shaded smooth", read="glb", write="glb", edit="bpy.ops.object.shade_smooth()"),
    Way(what="subdivided once, simple", read="ply", write="ply",
        edit=modifier("SUBSURF", subdivision_type="SIMPLE", levels=1)),
    Way(what="subdivided once, Catmull-Clark", read="ply", write="ply", edit=modifier("SUBSURF", levels=1)),
    Way(what="ends pulled by 3 %", read="ply", write="ply", edit=SCULPTED),
    Way(what="stretched by 10 % along one axis", read="ply", write="ply", edit=STRETCHED),
    Way(what="smoothed, 5 passes", read="ply", write="ply", edit=modifier("SMOOTH", iterations=5)),
    Way(what="decimated to half", read="ply", write="ply", edit=modifier("DECIMATE", ratio=0.5)),
    Way(what="decimated to a tenth", read="ply", write="ply", edit=modifier("DECIMATE", ratio=0.1)),
    Way(what="remeshed, voxels of 1 % of the height", read="ply", write="ply",
        edit="size = bpy.context.object.dimensions.z\n" + modifier("REMESH", mode="VOXEL")
        .replace("made = bpy.context.object.modifiers[-1]",
                 "made = bpy.context.object.modifiers[-1]\nmade.voxel_size = size / 100")),
)  # fmt: skip


def script(way: Way, source: Path, target: Path) -> str:
    """Return what Blender runs."""
    reader, writer = ({**ours, **gltf} for ours, gltf in zip((READ, WRITE), GLTF, strict=True))
    return "\n".join(
        [
            "import bpy",
            "bpy.ops.wm.read_factory_settings(use_empty=True)",
            f"{reader[way.read]}(filepath={str(source)!r})",
            "found = [o for o in bpy.data.objects if o.type == 'MESH'][0]",
            "bpy.context.view_layer.objects.active = found",
            "found.select_set(True)",
            way.edit,
            f"{writer[way.write]}(filepath={str(target)!r})",
        ]
    )


def main(blender: str) -> None:
    """Print a row for each way."""
    key = mm.Key(bytes(32))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "hare.ply").write_bytes(hare_ply())
        hare = mm.read_mesh(folder / "hare.ply")
        print(HEAD)
        for way in WAYS:
            source, target = folder / f"marked.{way.read}", folder / f"back.{way.write}"
            if not source.exists():
                mm.write_mesh(hare, folder / f"plain.{way.read}")
                plain = mm.read_mesh(folder / f"plain.{way.read}")
                result = mm.embed_file(plain, source, key, id=ID)
                result.certificate.save(folder / f"marked.{way.read}.cert")
            ran = subprocess.run(
                [blender, "-c", script(way, source, target)], capture_output=True, text=True, check=False
            )
            if not target.exists():
                sys.exit(ran.stdout + ran.stderr)
            back = mm.read_mesh(target)
            found, check = mm.extract(back, key), mm.authenticate(back, key)
            target.unlink()
            share = (
                f", {100 * check.altered.mean():.0f} % of the points" if check.verdict == "altered" else ""
            )
            seen = (
                "read" if found.id == ID else f"{found.presence}, another id" if found.ids else found.presence
            )
            verdict = check.verdict.replace("_", " ")
            print(f"| {way.read} | {way.what} | {way.write} | {seen} | {verdict}{share} |", flush=True)
            print(json.dumps([found.advice, check.advice]), file=sys.stderr, flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
