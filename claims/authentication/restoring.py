"""Recovery: altered parts brought back from what the intact part carries, and marks taken off again."""

from __future__ import annotations

from collections.abc import Iterator
from time import perf_counter

import numpy as np

import meshmark as mm
from claims.authentication.figures import Row
from claims.authentication.subjects import KEY, Subject
from claims.authentication.tampering import EDITS
from claims.marks import SHARES
from claims.recovery import compared, is_closed
from meshmark.attacks.attack import Attacked, Given
from meshmark.errors import InputError
from meshmark.marking import unmark
from meshmark.mesh import Mesh

__all__ = ["measure", "measure_unmark"]


def measure(subject: Subject, draws: int | None) -> Iterator[Row]:
    """Yield the errors before and after `recover`, of every edit or of `draws` of them."""
    rng = subject.rng("recovery")
    ways = [(edit, share) for edit in EDITS for share in SHARES]
    mesh = subject.marked.mesh
    for number in rng.permutation(len(ways))[:draws]:
        edit, share = ways[number]
        try:
            attacked = mm.ATTACKS[edit].apply(mesh, share, rng, Given(donor=subject.donor()))
        except InputError as error:
            print(f"  {edit} {share:g}: {error}")
            continue
        yield from _judged(subject.name, mesh, attacked, f"{edit} {100 * share:g} %")


def _judged(name: str, mesh: Mesh, attacked: Attacked, detail: str) -> Iterator[Row]:
    start = perf_counter()
    found = mm.recover(attacked.mesh, KEY)
    yield Row("recovered at all", name, detail, found.mesh is not None)
    if found.mesh is None:
        print(f"  {detail}: {found.advice}")
        return
    row = compared(mesh, attacked, found.mesh, ~_from(found.mesh, mesh), perf_counter() - start)
    print(f"  {detail}: {row.before:.3%} -> {row.after:.3%}, {row.seconds:.0f} s", flush=True)
    yield Row("RMS after recovery, % of the diagonal", name, detail, 100.0 * row.after)
    yield Row("times smaller than before", name, detail, row.before / max(row.after, 1e-9))
    if is_closed(mesh.faces) and not is_closed(attacked.mesh.faces):
        yield Row("watertight again", name, detail, is_closed(found.mesh.faces))


def _from(mesh: Mesh, other: Mesh) -> np.ndarray:
    """Return (n,): the vertices that lie exactly where one of the other mesh does."""
    there = {place.tobytes() for place in other.vertices}
    return np.array([place.tobytes() in there for place in mesh.vertices])


def measure_unmark(subject: Subject, _draws: int | None) -> Iterator[Row]:
    """Yield how far the unmarked model is from the original at most."""
    found = unmark(subject.marked.mesh, KEY, subject.marked.certificate)
    off = float(np.abs(found.mesh.vertices - subject.mesh.vertices).max()) / subject.diagonal
    yield Row("largest error after unmark, over the diagonal", subject.name, "", off)
