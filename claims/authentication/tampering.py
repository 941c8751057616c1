"""Edits: local edits and pasted parts are noticed, and the map shows where they are."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import meshmark as mm
from claims.authentication.figures import Row
from claims.authentication.subjects import KEY, Subject
from claims.marks import SHARES
from meshmark.attacks.attack import Attacked, Given
from meshmark.errors import InputError
from meshmark.metrics.tamper import iou, recall

__all__ = ["EDITS", "measure", "measure_pastes"]

EDITS = (
    "bump", "dent", "smooth_part", "move_part", "scale_part", "delete_part", "add_part", "replace_part", "paste"
)  # fmt: skip


def measure(subject: Subject, draws: int | None) -> Iterator[Row]:
    """Yield the figures of edits of every kind and size, or of `draws` of them."""
    rng = subject.rng("edits")
    ways = [(edit, share) for edit in EDITS for share in SHARES]
    for number in rng.permutation(len(ways))[:draws]:
        edit, share = ways[number]
        given = Given(donor=subject.donor())
        try:
            attacked = mm.ATTACKS[edit].apply(subject.marked.mesh, share, rng, given)
        except InputError as error:
            print(f"  {edit} {share:g}: {error}")
            continue
        yield from _judged(subject.name, attacked, share, f"{edit} {100 * share:g} %")


def _judged(name: str, attacked: Attacked, share: float, detail: str) -> Iterator[Row]:
    found = mm.authenticate(attacked.mesh, KEY)
    truth = attacked.altered
    assert truth is not None
    size = "at 0.5 %" if share < 0.02 else "at 2 % and more"
    yield Row("altered after a local edit", name, detail, found.verdict == "altered")
    yield Row(f"IoU {size}", name, detail, iou(truth, found.altered))
    yield Row(f"recall {size}", name, detail, recall(truth, found.altered))
    touched = np.zeros(len(found.regions), bool)
    touched[found.region[truth & (found.region >= 0)]] = True
    called = np.array([region.verdict == "altered" for region in found.regions])
    if not touched.all():
        false = float(called[~touched].mean())
        yield Row("untouched regions called altered", name, detail, false, int((~touched).sum()))


def measure_pastes(subject: Subject, _draws: int | None) -> Iterator[Row]:
    """Yield what comes of parts from another model, another place, and the same place under another id."""
    mesh, rng = subject.marked.mesh, subject.rng("pastes")
    for share in SHARES:
        elsewhere = mm.ATTACKS["shuffle"](mesh, 1, rng)
        sources = {
            "another model": subject.donor(),
            "another place": elsewhere,
            "another id": subject.upper.mesh,
        }
        for source, from_ in sources.items():
            try:
                attacked = mm.ATTACKS["paste"].apply(mesh, share, rng, Given(donor=from_))
            except InputError as error:
                print(f"  paste {source} {share:g}: {error}")
                continue
            found = mm.authenticate(attacked.mesh, KEY)
            assert attacked.origin is not None
            assert attacked.altered is not None
            new = attacked.origin < 0 if (attacked.origin < 0).any() else attacked.altered
            seen = float(found.altered[new].mean())
            flagged = found.verdict == "altered" and seen >= 0.5
            yield Row("pasted part flagged", subject.name, f"{source} {100 * share:g} %", flagged)
            yield Row(
                "share of the pasted part in the map", subject.name, f"{source} {100 * share:g} %", seen
            )
