"""Pictures of recovery for the docs: `python -m benchmarks.authentication.pictures [FOLDER]`.

The model that comes with the package, marked as by default, in four ways edited; what `authenticate` says of it, in
red; and what `recover` makes of it.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import meshmark as mm
from benchmarks.authentication.subjects import KEY
from meshmark.benchmark.models import load_shipped
from meshmark.mesh import Mesh
from meshmark.report.authentication import altered_colours
from meshmark.report.picture import Panel, panels

EDITS = {"bump": 0.05, "delete_part": 0.05, "replace_part": 0.05, "move_part": 0.2}
SIZE = 300
SEED = 2


def main() -> int:
    """Write a picture of each edit, and tell how large it is."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/images")
    marked = mm.embed(load_shipped(), KEY, id=1).mesh
    for edit, share in EDITS.items():
        edited = mm.ATTACKS[edit](marked, share, np.random.default_rng(SEED))
        found = mm.authenticate(edited, KEY)
        back = mm.recover(edited, KEY).mesh
        if back is None:
            print(f"{edit}: not recovered")
            continue
        shown = [_clay("as it was signed off", marked), _clay("edited", edited)]
        shown += [Panel("called altered", edited.vertices, edited.faces, altered_colours(found.altered))]
        path = folder / f"recovery-{edit.replace('_', '-')}.png"
        panels([*shown, _clay("recovered", back)], path, size=SIZE)
        print(f"{path}: {path.stat().st_size} bytes, {found.altered_area_fraction:.1%} called altered")
    return 0


def _clay(caption: str, mesh: Mesh) -> Panel:
    return Panel(caption, mesh.vertices, mesh.faces)


if __name__ == "__main__":
    sys.exit(main())
