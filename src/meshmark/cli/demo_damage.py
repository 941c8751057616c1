"""The second act of `meshmark demo`: the marked model is sawn in half and edited, and tells of both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from meshmark.cli.output import percent, plural
from meshmark.cli.progress import progress
from meshmark.cli.report_origin import report_origin

if TYPE_CHECKING:
    from meshmark.coding.keys import Key
    from meshmark.marking import Embedding
    from meshmark.mesh import FloatArray, Mesh
    from meshmark.report.picture import Panel

__all__ = ["Places", "bent", "damage"]

# The top of the model is pushed aside by this share of the diagonal, within that share of the diagonal around it.
PUSH, REACH = 0.06, 0.22
_SEED = 3


@dataclass(frozen=True)
class Places:
    """out: the folder that is named; work: where its files are until all of them are made."""

    out: Path
    work: Path

    def named(self, path: Path) -> Path:
        """Return the place to which a file of the work folder goes."""
        return self.out / path.relative_to(self.work)


Done = Callable[[str, str], None]


def damage(marked: Path, embedded: Embedding, key: Key, places: Places, done: Done) -> list[Panel]:
    """Saw, read, edit, check and bring back; return what to draw of it.

    marked: the file that `embedded` tells of; done: takes a word and a line for each step.
    """
    import numpy as np

    from meshmark.attacks import ATTACKS
    from meshmark.io import read_mesh, write_mesh
    from meshmark.report.own_colours import own_colours
    from meshmark.report.picture import Panel

    mesh = read_mesh(marked)
    sawn = ATTACKS["crop"].apply(mesh, 0.5, np.random.default_rng(_SEED))
    half, colours = sawn.mesh, own_colours(mesh).at_vertices()
    write_mesh(half, places.work / "half.ply")
    done("Sawn", f"{places.out / 'half.ply'}: one half, {plural(len(half.vertices), 'vertex/vertices')}")
    _read_half(half, embedded, key, places, done)
    colours = None if colours is None or sawn.origin is None else colours[sawn.origin]
    shown = [Panel(caption="sawn in half", points=half.vertices, faces=half.faces, colours=colours)]
    return shown + (_edit(marked, mesh, key, places, done) if embedded.mark_vertices else [])


def _read_half(half: Mesh, embedded: Embedding, key: Key, places: Places, done: Done) -> None:
    from meshmark.coding.message import format_id
    from meshmark.marking import extract

    embedded.certificate.save(places.work / "demo.cert")
    with progress("looking for the mark"):
        found = extract(half, key, reference=embedded.certificate)
    identity = "" if found.id is None else f", id {format_id(found.id)}"
    done("Read", f"in the half, with {places.out / 'demo.cert'}: {found.presence}{identity}")


def _edit(marked: Path, mesh: Mesh, key: Key, places: Places, done: Done) -> list[Panel]:
    from meshmark.io import read_mesh, write_mesh
    from meshmark.marking import authenticate, recover
    from meshmark.report.authentication_colours import altered_colours
    from meshmark.report.authentication_page import write_authentication_page
    from meshmark.report.own_colours import own_colours
    from meshmark.report.picture import Panel

    edited = marked.with_name(marked.name.replace("marked", "edited", 1))
    write_mesh(mesh.with_vertices(bent(mesh)), edited)
    done("Edited", f"{places.named(edited)}: its top bent")
    suspect = read_mesh(edited)
    with progress("checking the marks"):
        found = authenticate(suspect, key)
    page = marked.with_name("report.html")
    write_authentication_page(suspect, found, report_origin(suspect, edited, key), page)
    done("Checked", f"with the key alone: {found.verdict}; {found.advice} {places.named(page)}")
    with progress("recovering"):
        whole = recover(suspect, key)
    shown = [
        Panel(
            caption="its top bent",
            points=suspect.vertices,
            faces=suspect.faces,
            colours=own_colours(suspect).at_vertices(),
        ),
        Panel(
            caption="what was altered",
            points=suspect.vertices,
            faces=suspect.faces,
            colours=altered_colours(found.altered),
        ),
    ]
    if whole.mesh is None:
        done("Recover", whole.advice)
        return shown
    back = marked.with_name(marked.name.replace("marked", "recovered", 1))
    write_mesh(whole.mesh, back)
    done("Recover", f"{places.named(back)}: {_how_far(mesh, suspect, whole.mesh)}")
    return [
        *shown,
        Panel(
            caption="recovered",
            points=whole.mesh.vertices,
            faces=whole.mesh.faces,
            colours=own_colours(whole.mesh).at_vertices(),
        ),
    ]


def _how_far(marked: Mesh, edited: Mesh, back: Mesh) -> str:
    import numpy as np

    if back.vertices.shape != marked.vertices.shape:
        return "the altered part is cut out and replaced"
    touched = (edited.vertices != marked.vertices).any(axis=1)
    diagonal = np.linalg.norm(np.ptp(marked.vertices, axis=0))
    before, after = (
        float(np.sqrt(((mesh.vertices - marked.vertices)[touched] ** 2).sum(axis=1).mean()) / diagonal)
        for mesh in (edited, back)
    )
    return f"the altered part was {percent(before)} of the diagonal off RMS, now {percent(after)}"


def bent(mesh: Mesh) -> FloatArray:
    """Return (n, 3): the vertices with the top of the model, as pictures show it, pushed smoothly aside."""
    import numpy as np

    from meshmark.geometry.view import three_quarter_view

    view = three_quarter_view(mesh.vertices)
    diagonal = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    top = mesh.vertices[(mesh.vertices @ view[1]).argmax()]
    near = np.clip(1.0 - np.linalg.norm(mesh.vertices - top, axis=1) / (REACH * diagonal), 0.0, 1.0)
    push = (near**2 * (3.0 - 2.0 * near))[:, None] * PUSH * diagonal
    return np.asarray(np.where(near[:, None] > 0.0, mesh.vertices + push * view[0], mesh.vertices))
