"""The table of suites: what is measured, readable on one screen.

A part is (attacks, trial, repeats); a suite runs its parts at each of its budgets on every model.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from meshmark.research.benchmark.run.row import Case

__all__ = ["SUITES", "Part", "Suite", "cases"]


@dataclass(frozen=True, kw_only=True)
class Part:
    """Attacks, each made on a trial (one of `row.TRIALS`) this number of times with new random numbers."""

    attacks: tuple[str, ...]
    trial: str = "marked"
    repeats: int = 1


@dataclass(frozen=True, kw_only=True)
class Suite:
    """What is measured. fresh: each repeat marks the model anew, to time that too.

    schemes: those measured where none are named, as far as they are there. probes: names of `probes.PROBES`, what
    else is measured of each model.
    """

    about: str
    budgets: tuple[str, ...]
    parts: tuple[Part, ...]
    fresh: bool = False
    schemes: tuple[str, ...] = ("ncdg_lv",)
    probes: tuple[str, ...] = ()


def _each(name: str, *strengths: float | str) -> tuple[str, ...]:
    return tuple(f"{name}:{strength}" for strength in strengths)


_NOISE = _each("noise", 0.0005, 0.001, 0.003, 0.005, 0.01, 0.02)
_SMOOTHING = (*_each("smoothing", 5, 10, 30, 50), "smoothing_half:10", "taubin:10")
_QUANTISATION = _each("quantisation", 12, 11, 10, 9, 8, 7)
_SURFACE = (
    *("midpoint:1", "loop:1", "sqrt3:1"),
    *_each("simplification", 0.5, 0.7, 0.9, 0.95),
    *("remeshing:1", "voxels:256"),
)
_CROP = (*_each("crop", 0.03, 0.06, 0.09, 0.1, 0.3, 0.5), "crop:0.1+noise:0.003+similarity:1")
_HARMLESS = ("none", "similarity:1", "shuffle:1", "float32:1", "weld:1", "unweld:1")
_FILES = ("file_off:1", "file_obj:1", "file_ply:1", "file_stl:1", "file_glb:1", "file_gltf:1", "file_3mf:1")
_PAPER = (
    *("none", "similarity:1"),
    *_each("smoothing", 5, 10, 15),
    *_each("smoothing_half", 5, 10, 15),
    *_each("gaussian", 0.01, 0.02, 0.05),
    *_each("crop", 0.03, 0.06, 0.09),
)
# On an original or with a wrong key, an attack may not make a mark appear either.
_MILD = ("none", "similarity:1", "noise:0.003", "smoothing:10", "crop:0.1")

SUITES: dict[str, Suite] = {
    "smoke": Suite(
        about="the facts that must hold, in minutes",
        budgets=("standard",),
        parts=(
            Part(attacks=("none", "similarity:1", "shuffle:1", "float32:1", "file_obj:1", "midpoint:1")),
            Part(attacks=("noise:0.001", "smoothing:5", "quantisation:11", "simplification:0.5")),
            Part(attacks=("none",), trial="wrong key", repeats=2),
            Part(attacks=("none",), trial="unmarked"),
        ),
    ),
    "paper": Suite(
        about="the paper's tables, figures and ablation",
        budgets=("standard",),
        parts=(
            Part(attacks=_PAPER),
            Part(attacks=("none",), trial="wrong key"),
            Part(attacks=("none",), trial="unmarked"),
        ),
        schemes=("ncdg_lv", "laplace_beltrami", "mdaqim", "deep3d", "lsb"),
        probes=("salient points", "regions", "carriers"),
    ),
    "robust": Suite(
        about="every attack on the whole model, at both budgets of the mesh watermarking benchmark",
        budgets=("standard", "subtle"),
        parts=(
            Part(
                attacks=(
                    *_HARMLESS,
                    *_FILES,
                    *_NOISE,
                    *_SMOOTHING,
                    *_QUANTISATION,
                    *_SURFACE,
                    *_CROP,
                    "affine:0.02",
                )
            ),
            Part(attacks=("none",), trial="wrong key"),
            Part(attacks=("none",), trial="unmarked"),
        ),
    ),
    "ownership": Suite(
        about="what the mark must survive, at the standard strength",
        budgets=("standard",),
        parts=(
            Part(
                attacks=(
                    *_HARMLESS,
                    *_FILES,
                    *_NOISE,
                    *_SMOOTHING,
                    *_QUANTISATION,
                    *_SURFACE,
                    *_CROP,
                    "affine:0.02",
                )
            ),
            Part(attacks=("none",), trial="wrong key"),
            Part(attacks=("none",), trial="unmarked"),
        ),
    ),
    "security": Suite(
        about="what must not be found, and attacks on the use of marks",
        budgets=("standard",),
        parts=(
            Part(attacks=("none", "mirror:1", "paste:0.1", "second_mark:1", *_each("collusion", 2, 3, 5))),
            Part(attacks=("copy:1",), trial="forged"),
            Part(attacks=("none",), trial="wrong key", repeats=10),
            Part(attacks=_MILD, trial="wrong key"),
            Part(attacks=_MILD, trial="unmarked", repeats=2),
        ),
    ),
    "speed": Suite(
        about="time and memory, each mark made anew",
        budgets=("standard",),
        parts=(Part(attacks=("none",), repeats=5),),
        fresh=True,
    ),
}


def cases(name: str, scheme: str, model: str, seed: int) -> Iterator[Case]:
    """Yield the cases of a suite for one scheme and one model, each once, in the order of the table."""
    suite, seen = SUITES[name], set()
    for budget in suite.budgets:
        for part in suite.parts:
            for attack in part.attacks:
                for repeat in range(part.repeats):
                    case = Case(name, scheme, model, budget, attack, part.trial, seed, repeat)
                    if case not in seen:
                        seen.add(case)
                        yield case
