"""One case: the attack, the reading, and how far what was read is from the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import lru_cache
from math import log10
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from meshmark.attacks.attack import Attacked, Given
from meshmark.attacks.chain import parse_chain
from meshmark.coding.keys import Key
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.metrics.bits import ber, correlation, recovered
from meshmark.metrics.psnr import psnr_db
from meshmark.research import SCHEMES
from meshmark.research.benchmark.run.job import Mark, Outcome, mark_of, marks_of
from meshmark.research.benchmark.run.marked_model import key_of, original, payload_of
from meshmark.research.benchmark.run.marked_models import load_mark
from meshmark.research.benchmark.run.row import Case
from meshmark.research.benchmark.run.seeds import bits_for, generator_for, key_for
from meshmark.research.benchmark.run.shared_readings import blind_of
from meshmark.research.schemes.scheme import Bits, Readout, Scheme

__all__ = ["attacked_psnr_db", "judge"]

# Cases of a model follow each other.
_KEPT = 2


def judge(data: Path, out: Path, case: Case, schemes: Iterable[str] = ()) -> Outcome:
    """Attack and read; raises what the attack or the scheme raises.

    schemes: of the run; where one of them reads the same suspect blind, that is not done here again.

    Other schemes, budgets and trials meet the same attack: its random numbers depend on the seed, the model, the
    attack and the repeat only.
    """
    scheme, chain = SCHEMES[case.scheme], parse_chain(case.attack)
    whole = original(data, case.model)
    main, marks = mark_of(case), marks_of(case)
    held = {mark: load_mark(out, mark) for mark in marks}
    suspect = held[main] if main in held else Mesh(whole.vertices, whole.faces)
    rng = generator_for("attack", case.seed, case.model, case.attack, case.repeat)
    start = perf_counter()
    made = chain.apply(suspect, rng, _given(case, held, scheme))
    attacked, attack_seconds = made.mesh, perf_counter() - start

    key = key_of(main) if case.trial != "wrong key" else _stranger(case, "wrong key")
    reference = None if scheme.blind else _reference(data, out, case.scheme, main, main in held)
    extract = scheme.extract if blind_of(case, schemes) is None else _by_reference(scheme)
    start = perf_counter()
    readout = extract(attacked, key, reference=reference)
    seconds = perf_counter() - start
    truths = {payload_of(mark, scheme.bits).tobytes(): mark for mark in marks or [main]}
    figures = _figures(readout, [np.frombuffer(bits, np.uint8) for bits in truths], scheme, key)
    times = {
        "attack_seconds": attack_seconds,
        "extract_seconds": seconds,
        "vertices_per_second": len(attacked.vertices) / seconds,
    }
    figures["attacked_psnr_db"] = attacked_psnr_db(whole, made)
    return Outcome(status="ok", figures={**figures, **times})


def attacked_psnr_db(whole: Mesh, made: Attacked) -> float | None:
    """Return the PSNR of what is left of the original's vertices; None where nothing tells which they are."""
    if made.origin is None or not (made.origin >= 0).any():
        return None
    kept = made.origin >= 0
    origin = made.origin[kept]
    vertices, left = whole.vertices.copy(), np.zeros(len(whole.vertices), bool)
    vertices[origin], left[origin] = made.mesh.vertices[kept], True
    # vertices that are gone count as unmoved there, so their share is taken off the mean
    return psnr_db(Mesh(whole.vertices, whole.faces), Mesh(vertices, whole.faces)) + 10.0 * log10(left.mean())


@lru_cache(maxsize=_KEPT)
def _reference(data: Path, out: Path, scheme: str, mark: Mark, marked: bool) -> Any:
    """Return what the owner has kept, of the marked model where there is one, else the original."""
    whole = original(data, mark.owner)
    kept = getattr(SCHEMES[scheme], "kept", None)
    return whole if kept is None else kept(load_mark(out, mark) if marked else whole, key_of(mark))


def _by_reference(scheme: Scheme) -> Callable[..., Readout]:
    """Return how a scheme reads by its reference alone."""
    by_reference: Callable[..., Readout] = scheme.extract_by_reference  # type: ignore[attr-defined]
    return by_reference


def _given(case: Case, held: dict[Mark, Mesh], scheme: Scheme) -> Given:
    """Return what the attacker has: copies with other ids, another model with this key, a key of its own."""
    copies = tuple(mesh for mark, mesh in held.items() if mark.number)
    donor = next((mesh for mark, mesh in held.items() if mark.donor), None)

    def embed(mesh: Mesh) -> Mesh:
        bits = bits_for(scheme.bits, "second mark", *_names(case))
        return scheme.embed(mesh, bits, _stranger(case, "second mark"), strength=case.budget)

    return Given(copies=copies, donor=donor, embed=embed)


def _stranger(case: Case, role: str) -> Key:
    return key_for(role, *_names(case))


def _names(case: Case) -> tuple[str | int, ...]:
    # Schemes that read the same marks meet the same strangers.
    return case.seed, mark_of(case).scheme, case.model, case.budget, case.attack, case.trial, case.repeat


def _figures(
    readout: Readout, truths: list[Bits], scheme: Scheme, key: Key
) -> dict[str, float | bool | None]:
    """Compare a readout with the payloads that would be right, taking the nearest."""
    bits = np.asarray(readout.bits)
    if bits.shape != (scheme.bits,) or not np.isin(bits, (0, 1)).all():
        raise InputError(f"the scheme read bits of shape {bits.shape}, expected {scheme.bits} zeros and ones")
    truth = min(truths, key=lambda each: ber(each, bits))
    return {
        "ber": ber(truth, bits),
        "raw_ber": _raw_ber(readout, truth, scheme, key),
        "correlation": correlation(truth, bits),
        "present": bool(readout.present),
        "recovered": bool(readout.present) and bool(recovered(truth, bits)),
        "log10_false_positive": readout.log10_false_positive,
        "decoded": bool(readout.decoded),
    }


def _raw_ber(readout: Readout, truth: Bits, scheme: Scheme, key: Key) -> float | None:
    code = getattr(scheme, "code", None)
    if readout.raw is None or code is None or not readout.raw.any():
        return None
    seen = readout.raw != 0.0
    return float(((readout.raw < 0.0) != code(truth, key).astype(bool))[seen].mean())
