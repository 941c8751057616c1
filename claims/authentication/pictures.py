"""Pictures of recovery for the docs: `python -m claims.authentication.pictures [FOLDER]`.

The model that comes with the package, a quarter of its faces, marked as by default, in three ways edited; what
`authenticate` says of it, in red; and what `recover` makes of it.
"""

from __future__ import annotations

import sys
from itertools import count
from pathlib import Path
from zlib import crc32

import numpy as np

import meshmark as mm
from claims.authentication.subjects import KEY
from meshmark.geometry.areas import vertex_normals
from meshmark.geometry.view import three_quarter_view
from meshmark.mesh import FloatArray, Mesh
from meshmark.report.authentication_colours import altered_colours
from meshmark.report.picture import Panel, panels
from meshmark.research.benchmark.run.model_files import load_shipped

EDITS = ("bump", "delete_part", "replace_part")
SHARE = 0.05
SIZE = 300
SEED = 2
FACING = 0.6
"""Mean cosine between what was edited and the line of sight."""


def main() -> int:
    """Write a picture of each edit, and tell how large it is."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/images")
    light = mm.ATTACKS["simplification"](load_shipped(), 0.75, np.random.default_rng(SEED))
    marked = mm.embed(light, KEY, id=1).mesh
    view = three_quarter_view(marked.vertices)
    for edit in EDITS:
        edited = _facing(marked, edit, view[2])
        found = mm.authenticate(edited, KEY)
        back = mm.recover(edited, KEY).mesh
        if back is None:
            print(f"{edit}: not recovered")
            continue
        shown = [_clay("as it was signed off", marked), _clay("edited", edited)]
        shown += [
            Panel(
                caption="called altered",
                points=edited.vertices,
                faces=edited.faces,
                colours=altered_colours(found.altered),
            )
        ]
        path = folder / f"recovery-{edit.replace('_', '-')}.png"
        panels([*shown, _clay("recovered", back)], path, size=SIZE, view=view)
        print(f"{path}: {path.stat().st_size} bytes, {found.altered_area_fraction:.1%} called altered")
    return 0


def _facing(mesh: Mesh, edit: str, viewer: FloatArray) -> Mesh:
    """Return the mesh edited where it is seen, at the first random place that is."""
    for seed in count(SEED):
        attacked = mm.ATTACKS[edit].apply(mesh, SHARE, np.random.default_rng([seed, crc32(edit.encode())]))
        towards = vertex_normals(attacked.mesh.vertices, attacked.mesh.faces)[attacked.altered] @ viewer
        if towards.mean() > FACING:
            return attacked.mesh
    raise AssertionError("unreachable: some place is seen")


def _clay(caption: str, mesh: Mesh) -> Panel:
    return Panel(caption=caption, points=mesh.vertices, faces=mesh.faces)


if __name__ == "__main__":
    sys.exit(main())
