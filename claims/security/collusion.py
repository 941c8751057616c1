"""Customers who put their copies of one model together: means, medians, least and largest coordinates.

Copies are marked as by default (both layers). Of two copies the key alone must read both ids; of more they are
looked for among issued ids. Whoever is named and took no part is counted; besides, readings of these suspects are
compared with lists of ids of which none is in them. Three copies a + b - c show the sum of three words, which is
the word of an id that nobody has: no id must be named there.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from time import monotonic

import numpy as np

import meshmark as mm
from claims.security.options import KEY, Options
from claims.security.table import Figure
from meshmark.coding.codec import Codec
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership.parameters import PROVEN_LOG10
from meshmark.ownership.search.search import Search
from meshmark.ownership.search.strategies import STRATEGIES

__all__ = ["GROUPS", "MEANS", "Answer", "answer", "collusion", "innocents", "suspects"]

MODELS, LEAST = 20, 5000
MEANS: dict[str, Callable[[FloatArray], FloatArray]] = {
    "average": lambda copies: copies.mean(axis=0),
    "median": lambda copies: np.median(copies, axis=0),
    "minimum": lambda copies: copies.min(axis=0),
    "maximum": lambda copies: copies.max(axis=0),
}
"""What k copies (k, n, 3) become."""
GROUPS = (2, 3, 5)
ISSUED = 10_000
SHARES = {2: 0.95, 3: 0.95, 5: 0.80}
"""What the bars ask of each size of group: of two both ids, of more at least one."""
TRIALS, LISTED = 20_000, 1000
# A reading whose lock is less likely than 10^this by chance is compared with lists.
LOCKED_LOG10 = -3.0


@dataclass(frozen=True, kw_only=True)
class Answer:
    """Of one suspect: how many took part, how many of these were named, and how many others."""

    group: int
    mean: str
    right: int
    wrong: int


def collusion(options: Options) -> list[Figure]:
    """Return how often colluders are named, by group, and innocents."""
    answers: list[Answer] = []
    sums: list[int] = []
    seen: list[FloatArray] = []
    rng = options.rng(10)
    issued = [int(each) for each in rng.integers(2**63, size=ISSUED - max(GROUPS), dtype=np.int64)]
    models = 0
    for name, mesh in options.meshes("models", least=max(options.least, LEAST)):
        ids = [int(each) for each in rng.integers(2**63, size=max(GROUPS), dtype=np.int64)]
        try:
            copies = np.array([mm.embed(mesh, KEY, id=each).mesh.vertices for each in ids])
        except mm.MeshmarkError as error:
            print(f"{name}: {error}")
            continue
        for group, mean, suspect in suspects(mesh, copies):
            answers.append(answer(suspect, ids, group=group, mean=mean, issued=issued))
            seen += _readings(suspect) if mean == "average" else []
        sums.append(len(mm.extract(mesh.with_vertices(copies[0] + copies[1] - copies[2]), KEY).ids))
        models += 1
        own = " ".join(f"{each.group}{each.mean[:3]} {each.right}+{each.wrong}" for each in answers[-9:])
        print(f"{name} ({len(mesh.vertices)}): {own}, a + b - c {sums[-1]}", flush=True)
        if models == options.count(MODELS) or monotonic() > options.end:
            break
    trials = TRIALS if options.tries is None else options.tries
    added = Figure(
        name="three copies added up, a + b - c: any id named",
        measured=str(sum(each > 0 for each in sums)),
        of=f"{len(sums)} suspects, {models} models",
        bar="0",
        met=not any(sums),
    )
    return [*_figures(answers, models), added, innocents(seen, trials, options)]


def suspects(mesh: Mesh, copies: FloatArray) -> Iterator[tuple[int, str, Mesh]]:
    """Yield what is made of the first 2, 3 and 5 copies (k, n, 3): group, kind and model.

    Of two, the median is the average.
    """
    for group in GROUPS:
        for mean, made in MEANS.items():
            if (group == 2 and mean == "median") or group > len(copies):
                continue
            yield group, mean, mesh.with_vertices(made(copies[:group]))


def answer(suspect: Mesh, ids: list[int], *, group: int, mean: str, issued: list[int]) -> Answer:
    """Read a suspect made of the first `group` of the copies with these ids: two blind, more among issued ids."""
    among = () if group == 2 else (*issued, *ids)
    found = set(mm.extract(suspect, KEY, among=among).ids)
    right = len(found & set(ids[:group]))
    return Answer(group=group, mean=mean, right=right, wrong=len(found) - right)


def _figures(answers: list[Answer], models: int) -> list[Figure]:
    rows = []
    by: dict[tuple[int, str], list[Answer]] = defaultdict(list)
    for each in answers:
        by[each.group, each.mean].append(each)
        by[each.group, "all"].append(each)
    for (group, mean), own in sorted(by.items()):
        enough = sum(each.right >= (2 if group == 2 else 1) for each in own)
        asked = SHARES[group]
        rows.append(
            Figure(
                name=f"{mean} of {group}: {'both ids' if group == 2 else 'at least one id'}",
                measured=f"{enough} ({sum(each.right > 0 for each in own)} with any)",
                of=f"{len(own)} suspects, {models} models",
                bar=f"{asked:.0%}" if mean == "all" else "",
                met=enough >= asked * len(own) if mean == "all" else None,
            )
        )
    wrong = sum(each.wrong for each in answers)
    name = "ids named that took no part, by the answers above"
    return [
        *rows,
        Figure(name=name, measured=str(wrong), of=f"{len(answers)} suspects", bar="0", met=wrong == 0),
    ]


def _readings(suspect: Mesh) -> list[FloatArray]:
    """Return what the code bits look like in the readings of a suspect that lock."""
    search = Search(surface=surface_of(suspect), key=KEY, effort="plain")
    first = next(each for each in STRATEGIES if each.name == "as it stands")
    return [each.observed() for each in first.readings(search) if each.log10_chance < LOCKED_LOG10]


def innocents(seen: list[FloatArray], trials: int, options: Options) -> Figure:
    """Compare readings of averages with lists of ids that are in none of them, until there are so many trials."""
    rng = options.rng(11)
    codec = Codec(KEY)
    named = done = 0
    while done < trials and seen:
        words = codec.words([int(each) for each in rng.integers(2**63, size=LISTED, dtype=np.int64)])
        for observed in seen[: trials - done]:
            named += bool((codec.chances(observed, words) <= PROVEN_LOG10).any())
            done += 1
    return Figure(
        name=f"lists of {LISTED:,} ids that are not in an average: any named",
        measured=str(named),
        of=f"{done:,} trials",
        bar="0",
        met=named == 0,
    )
