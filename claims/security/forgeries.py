"""Authentication marks forged without the key: at two tolerances, and where they are too few to tell their places.

The kinds of forgery are those of `claims.authentication.forging`: edited parts with marks guessed, made with
another key, or replayed from another place or another model; single rings replayed with their mark; lone marks
guessed. In a file that was rounded to a grid of 14 bits up to four altered points that hang together pass by
design: there every try is judged by `authenticate`, and fewer are made. An authentic try is a forgery where it
moves a point that a mark watches by a step of the marks; others are counted apart.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice, zip_longest
from time import monotonic
from zlib import crc32

import numpy as np

import meshmark as mm
from claims.authentication.forging import Forger, Try
from claims.authentication.subjects import KEY, Subject
from claims.security.options import Options
from claims.security.table import Figure
from meshmark.attacks import ATTACKS
from meshmark.errors import MeshmarkError
from meshmark.marking import Embedding
from meshmark.mesh import FloatArray

__all__ = ["SETTINGS", "Counted", "forgeries", "measured"]

MODELS, TRIES = 12, 10_000
SMALL = (300, 1300)
"""Points of models whose marks are too few to tell where they lie."""
ROUNDED = "web, 14 bits"
SETTINGS = ("default", "web", ROUNDED, "small")
GRID, FEWER = 14, 20


@dataclass(frozen=True, eq=False)
class Tolerant(Subject):
    """A model marked with both layers at a named tolerance."""

    tolerance: str = "default"
    bits: int | None = None

    @cached_property
    def marked(self) -> Embedding:
        """Marked so; raises `CapacityError` where there is no room."""
        id = crc32(self.name.encode())
        made = mm.embed(self.mesh, KEY, id=id, layers="both", tolerance=self.tolerance)
        if self.bits is None:
            return made
        return replace(made, mesh=ATTACKS["quantisation"](made.mesh, self.bits, self.rng("grid")))


class Watching(Forger):
    """A forger of what is watched; harmless: authentic tries that moved no point beside a mark by a step."""

    harmless = 0

    def authentic(self, points: FloatArray) -> bool:
        """Return whether the model with these points (p, 3) is authentic though one of them was moved."""
        if not super().authentic(points):
            return False
        moved = np.linalg.norm(points - self.surface.points, axis=1)[self.vouching.sure]
        is_forged = bool((moved > self.vouching.typical_step).any())
        self.harmless += not is_forged
        return is_forged


class Unscreened(Watching):
    """A forger whose every try is judged by `authenticate`: some pass without a voucher for each point."""

    def accepted(self, change: Try, count: int, rng: np.random.Generator) -> int:
        """Return how many of these tries are authentic."""
        accepted = 0
        for _ in range(count):
            points = self.surface.points.copy()
            while not change(points, rng):
                points = self.surface.points.copy()
            accepted += self.authentic(points)
        return accepted


@dataclass(frozen=True, kw_only=True)
class Counted:
    """Forgeries of one kind on one model, how many of them are authentic, and how many moved nothing watched."""

    setting: str
    kind: str
    model: str
    accepted: int
    harmless: int
    tries: int


def forgeries(options: Options) -> list[Figure]:
    """Return how many forgeries of each kind are accepted, by setting: a model of each in turn."""
    tries = TRIES if options.tries is None else options.tries
    rounds = [islice(_models(options, setting, tries), options.count(MODELS)) for setting in SETTINGS]
    return _figures([row for done in zip_longest(*rounds, fillvalue=[]) for rows in done for row in rows])


def _models(options: Options, setting: str, tries: int) -> Iterator[list[Counted]]:
    """Yield what was counted on each model, until the time is over."""
    for subject in _subjects(options, setting):
        try:
            rows = list(measured(subject, setting, tries, options.end))
        except MeshmarkError as error:
            print(f"{setting}, {subject.name}: {error}", flush=True)
            continue
        said = ", ".join(f"{each.kind} {each.accepted} of {each.tries}" for each in rows if each.accepted)
        print(f"{setting}, {subject.name}: {sum(each.tries for each in rows):,} tries; {said}", flush=True)
        yield rows


def _subjects(options: Options, setting: str) -> Iterator[Subject]:
    sized = options
    if setting == "small":
        sized = Options(
            split=options.split, seed=options.seed, least=SMALL[0], most=SMALL[1], end=options.end
        )
    tolerance = "web" if setting.startswith("web") else "default"
    bits = GRID if setting == ROUNDED else None
    for name, mesh in sized.meshes(*(("models", "psb") if setting == "small" else ("models",))):
        yield Tolerant(name, mesh, tolerance=tolerance, bits=bits)


def measured(subject: Subject, setting: str, tries: int, end: float = float("inf")) -> Iterator[Counted]:
    """Yield how many of so many tries of each kind are accepted, until the time is over."""
    rounded = setting == ROUNDED
    forger = Unscreened(subject) if rounded else Watching(subject)
    tries = max(tries // FEWER, 1) if rounded else tries
    for kind, change in (forger.parts | forger.lone).items():
        if monotonic() > end:
            return
        forger.harmless = 0
        accepted = forger.accepted(change, tries, subject.rng(kind))
        yield Counted(
            setting=setting,
            kind=kind,
            model=subject.name,
            accepted=accepted,
            harmless=forger.harmless,
            tries=tries,
        )


def _figures(counted: list[Counted]) -> list[Figure]:
    by: dict[tuple[str, str], list[Counted]] = defaultdict(list)
    for each in counted:
        by[each.setting, each.kind].append(each)
    return [
        Figure(
            name=f"{setting}: {kind}",
            measured=f"{sum(each.accepted for each in own)} ({sum(each.harmless for each in own)} harmless)",
            of=f"{sum(each.tries for each in own):,} on {len(own)} models",
            bar="0",
            met=not any(each.accepted for each in own),
        )
        for (setting, kind), own in by.items()
    ]
