"""An attacker with originals and marked copies of one key, and further marked models: what does he know of others?

20 pairs and 50 marked models. All that they show of a lattice goes into one estimate, as if the key had one
lattice; its error on a model that was left out must be uniform. Then he is granted the pose of each lattice, also
that of the model that is attacked, and predicts phases by the nodes that he has seen. He forges the mark of each
donor on unmarked models, makes words of three copies of a model, and moves marked models at the cells that he
expects.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, islice
from time import monotonic

import numpy as np
from scipy.stats import ks_2samp

import meshmark as mm
from claims.security.donors import Donor, donors, forged, learnt, measured
from claims.security.options import KEY, Options
from claims.security.point_phases import point_phases
from claims.security.pose import Energy, Guess, energy_alone, energy_of_pair, guessed, off_by
from claims.security.table import Figure
from claims.security.uniformity import uniformity
from claims.security.washing import bumps_at, random_field, size_needed
from meshmark.errors import MeshmarkError
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import FloatArray, Mesh
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.nodes import find_nodes
from meshmark.ownership.embedding import embed
from meshmark.ownership.extraction import extract

__all__ = ["forgeries", "pairs", "phase_errors", "pose_errors", "removals", "xored"]

PAIRS, ALONE = 20, 50
FOLDS = 10
FORGERIES = 200
VICTIM = 0x0123456789ABCDEF
"""The id that every donor of a forgery carries: what a forgery may say."""
COPIES = 6
REMOVED = 8
# A forgery is read as it stands, which is what it is made for; one in so many by the whole search, too.
WHOLE = 10


def pairs(options: Options) -> Iterator[Figure]:
    """Yield the figures of all that is tried."""
    count, alone = options.count(PAIRS), round(ALONE / PAIRS * options.count(PAIRS))
    held = list(islice(donors(options, "models", "psb"), count + alone))
    print(f"{len(held)} models marked", flush=True)
    tries = FORGERIES if options.tries is None else options.tries
    yield from _poses(held, count, options)
    yield _phases(held)
    yield point_phases(options)
    yield forgeries(held, tries, options)
    yield xored(tries, options)
    yield from removals(held, count, options)


def pose_errors(
    energies: list[Energy], lattices: list[Lattice], options: Options
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return, of models left out of the estimate: degrees (m,), turns (m, 3), and degrees (m,) of random guesses.

    energies: of the models; lattices: that they truly have.
    """
    degrees, turns, random = [], [], []
    rng = options.rng(1)
    folds = min(FOLDS, len(energies))
    for fold in range(folds):
        guess = guessed([each for row, each in enumerate(energies) if row % folds != fold], rng)
        for row in range(fold, len(energies), folds):
            lattice = lattices[row]
            angle, error = off_by(guess, lattice.axes, lattice.shift, lattice.spacing)
            blind = Guess(axes=np.linalg.qr(rng.normal(size=(3, 3)))[0], shifts={})
            random.append(off_by(blind, lattice.axes, lattice.shift, lattice.spacing)[0])
            degrees.append(angle)
            turns.append(error)
    return np.array(degrees), np.array(turns), np.array(random)


def _poses(held: list[Donor], count: int, options: Options) -> list[Figure]:
    energies = [
        energy_of_pair(each.original, each.marked, each.mark.spacing)
        if row < count
        else energy_alone(each.marked, each.mark.spacing)
        for row, each in enumerate(held)
    ]
    degrees, turns, random = pose_errors(energies, [each.lattice for each in held], options)
    shift = uniformity(turns.ravel())
    alike = float(ks_2samp(degrees, random).pvalue)
    own = [
        off_by(guessed([energy], options.rng(2)), each.lattice.axes, each.lattice.shift, each.mark.spacing)
        for energy, each in zip(energies[:count], held, strict=False)
    ]
    found = sum(angle < 3.0 for angle, _ in own)
    return [
        shift.figure(
            "phase of the lattice's waves of a model left out, predicted",
            f"{shift.count} phases, {len(held)} models",
        ),
        Figure(
            name="turn of that lattice, beside random guesses",
            measured=f"median {np.median(degrees):.1f} degrees, guesses {np.median(random):.1f}; p = {alike:.2g}",
            of=f"{len(degrees)} models",
            bar="p above .01",
            met=alike > 0.01,
        ),
        Figure(
            name="lattice of a pair's own model found to 3 degrees (from the pair itself)",
            measured=str(found),
            of=f"{len(own)} pairs",
        ),
    ]


def phase_errors(target: Donor, others: list[Donor]) -> FloatArray:
    """Return the error (n,), in turns, of phases predicted by the others at equal nodes of the granted lattices.

    Of doubled phases but for pilots: a bit is half a turn.
    """
    cells = measured(target.marked, target.lattice)
    seen = cells.cells.offset / target.mark.step
    errors = []
    for other in others:
        known = measured(other.marked, other.lattice).cells
        row = find_nodes(known.nodes, cells.cells.nodes)
        both = row >= 0
        predicted = known.offset[row[both]] / other.mark.step
        errors.append(cells.keys.factor[both] * (seen[both] - predicted))
    return np.concatenate(errors) if errors else np.zeros(0)


def _phases(held: list[Donor]) -> Figure:
    """Return how well cells predict those of another model with the same spacing, one prediction for each cell."""
    errors = []
    for row, target in enumerate(held):
        same = [other for other in held[:row] if abs(other.mark.spacing - target.mark.spacing) < 1e-9]
        errors.append(phase_errors(target, same[-1:]))
    phases = uniformity(np.concatenate(errors))
    name = "phases of cells, predicted by another model's at the same nodes, poses granted"
    return phases.figure(name, f"{phases.count} cells")


def forgeries(held: list[Donor], tries: int, options: Options) -> Figure:
    """Forge the marks of donors on the unmarked originals of others."""
    present = named = done = 0
    sources = held[: max(2, len(held) // 2)]
    victims = [Donor.of(each.name, each.original, VICTIM) for each in sources]
    library = [learnt(each) for each in victims if not each.mark.at_points]
    targets = held[len(sources) :] or held
    for number in range(tries):
        target = targets[number % len(targets)].original
        row = (number // len(targets) + number) % len(library)
        suspect = forged(target, library[row], victims[row].mark.step)
        said = _read(suspect, whole=number % WHOLE == 0)
        present, named, done = (
            present + (said.presence == "present"),
            named + (VICTIM in said.ids),
            done + 1,
        )
        if monotonic() > options.end:
            break
    return Figure(
        name="marks of donors forged on unmarked models, poses granted: present, with their id",
        measured=f"{present}, {named}",
        of=f"{done} forgeries",
        bar="0",
        met=present + named == 0,
    )


def _read(suspect: Mesh, *, whole: bool) -> mm.Extraction:
    said = extract(suspect, KEY, search="plain")
    return mm.extract(suspect, KEY) if whole and said.presence != "present" else said


def xored(tries: int, options: Options) -> Figure:
    """Make of three copies of a model, with ids a, b and c, one whose cells have the bits a ^ b ^ c.

    As phases are linear in the displacement, a + b - c of the positions does it. The ids are chosen so that
    a ^ b ^ c is an innocent's.
    """
    framed = anyone = done = 0
    for number, (_, mesh) in enumerate(options.meshes("models", "psb")):
        ids = [8 * number + each for each in range(8, 8 + COPIES)]
        try:
            copies = [embed(mesh, KEY, id=each).mesh.vertices for each in ids]
        except MeshmarkError:
            continue
        for one, other, third in combinations(range(COPIES), 3):
            suspect = mesh.with_vertices(copies[one] + copies[other] - copies[third])
            innocent = ids[one] ^ ids[other] ^ ids[third]
            found = extract(suspect, KEY, search="plain", copies=True).ids
            framed += innocent in found
            anyone += bool(set(found) - {ids[one], ids[other], ids[third]})
            done += 1
            if done == tries or monotonic() > options.end:
                break
        if done == tries or monotonic() > options.end:
            break
    return Figure(
        name="three copies added up to an innocent id: that id read; any other than theirs",
        measured=f"{framed}; {anyone}",
        of=f"{done} forgeries",
        bar="0; 0",
        met=framed + anyone == 0,
    )


def removals(held: list[Donor], count: int, options: Options) -> list[Figure]:
    """Move marked models at the cells of the lattice that all others together suggest, and at random."""
    rng = options.rng(3)
    ratios: dict[str, list[float]] = {"at the cells expected": [], "keyless": [], "at the true cells": []}
    energies = [energy_of_pair(each.original, each.marked, each.mark.spacing) for each in held[:count]]
    most = min(REMOVED, max(count // 4, 1))
    for number, target in enumerate(held[-most:]):
        if monotonic() > options.end:
            break
        row = len(held) - most + number
        rest = [each for place, each in enumerate(energies) if place != row]
        guess = guessed(rest, rng)
        spacing = target.mark.spacing
        fields = {
            "at the cells expected": _at_nodes(target.marked, guess.axes, guess.shift(spacing), spacing, rng),
            "keyless": random_field(target.marked, spacing, rng),
            "at the true cells": _at_nodes(
                target.marked, target.lattice.axes, target.lattice.shift, spacing, rng
            ),
        }
        for name, field in fields.items():
            needed = size_needed(target.marked, target.id, field, 2.4 * target.rms, halvings=3)
            ratios[name].append(needed / target.rms)
        print(
            f"{target.name}: " + ", ".join(f"{name} {each[-1]:.2f}" for name, each in ratios.items()),
            flush=True,
        )
    return [
        Figure(
            name=f"displacement that takes an id away, {name}, over the mark's own",
            measured=f"median {np.median(each):.2f}, least {min(each):.2f}",
            of=f"{len(each)} models",
            bar="at least 1" if name == "at the cells expected" else "",
            met=bool(min(each) >= 1.0) if name == "at the cells expected" else None,
        )
        for name, each in ratios.items()
        if each
    ]


def _at_nodes(
    mesh: Mesh, axes: FloatArray, shift: FloatArray, spacing: float, rng: np.random.Generator
) -> FloatArray:
    """Return a field with a bump at each node of a lattice that has surface near."""
    surface = surface_of(mesh)
    places = surface.frame.to_canonical(surface.points)
    nodes = np.unique(np.round(places @ (axes.T / spacing) + shift), axis=0)
    return bumps_at(mesh, (nodes - shift) @ (axes * spacing), spacing, rng)
