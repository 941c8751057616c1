"""How often points lock by chance, and what a small error of the frame does to their phases."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from meshmark.coding.keys import Key
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.pose import Pose
from meshmark.ownership.points.carried_coordinates import Carried
from meshmark.ownership.points.parameters import MODES, SHARES, STEPS
from meshmark.ownership.points.point_choice import Choice
from meshmark.ownership.points.point_lattice import PointLattice
from meshmark.ownership.points.point_reading import CHOICES, Framed, PointLock
from tests.counting import some
from tests.low_poly import ball, sheet

DRAWS, FEWER = 2000, 500
LABEL = Label(bytes(16))


@cache
def clumps():
    """Return a flat sheet whose points lie in clumps smaller than a cube: many share what the key says."""
    cuts = np.sort((np.array([0.0, 0.22, 0.45, 0.71, 1.0])[:, None] + [0.0, 0.006, 0.013]).ravel())
    surface = surface_of(Mesh(*sheet(cuts, 0.8 * cuts)))
    return surface, Carried.of(surface, surface.frame)


@cache
def drawn() -> list[Framed]:
    """Return the clumps read with many keys."""
    surface, carried = clumps()
    keys = (Key(number.to_bytes(32, "little")) for number in range(DRAWS))
    return [Framed.of(surface, carried, surface.frame, PointLattice.keyed(key, LABEL)) for key in keys]


def below(log10_chances, power):
    return float((np.asarray(log10_chances) < -power).mean())


def test_the_points_share_what_the_key_says():
    framed = drawn()[0]
    assert len(framed.points) == 225
    assert len(np.unique(framed.group)) < 0.4 * framed.group.size


@pytest.mark.parametrize("mode", [1, 3])
def test_one_choice_locks_by_chance_no_oftener_than_it_says(mode):
    choice = Choice(step=float(STEPS[4]), mode=mode, share=1.0)
    readings = [framed.reading(choice, 1.0) for framed in drawn()]
    told = [reading.log10_chance for reading in readings]
    # As if no two coordinates shared a dither.
    independent = [-(max(each.score, 0.0) ** 2) / len(each.phase) / np.log(10.0) for each in readings]
    for power in (1, 2, 3):
        expected = 10.0**-power
        assert below(told, power) <= expected + 3.0 * np.sqrt(expected / DRAWS)
    assert below(told, 1) > 0.01  # nor is it empty
    assert below(independent, 3) > 0.01


def test_the_best_of_all_choices_locks_by_chance_no_oftener_than_all_of_them_may():
    best = [
        min(framed.reading(lock.choice, 1.0).log10_chance for lock in framed.locks())
        for framed in drawn()[:FEWER]
    ]
    for power in (3, 4, 5, 6):
        expected = CHOICES * 10.0**-power
        assert below(best, power) <= expected + 3.0 * np.sqrt(expected / FEWER)
    assert below(best, 1) > 0.2


def test_locks_are_those_that_readings_have():
    framed = drawn()[3]
    locks = some(framed.locks(), len(STEPS))
    assert {lock.choice.mode for lock in locks} == set(range(len(MODES)))
    for lock in locks:
        assert framed.reading(lock.choice, 1.0).log10_chance == pytest.approx(lock.log10_loose, abs=1e-5)
        others = [framed.reading(replace(lock.choice, share=share), 1.0) for share in SHARES]
        enough = [each.log10_chance for each in others if len(each.phase) >= 100]
        assert min(some(enough)) > lock.log10_loose - 1e-5


def framed_anywhere(places: np.ndarray, lattice: PointLattice) -> Framed:
    """Return points (n, 3) in a frame, all of whose coordinates carry at every step."""
    keys = lattice.keys(lattice.cubes(places))
    return Framed(
        points=places,
        coordinates=(np.ones(places.shape, bool),) * len(MODES),
        room=np.ones((len(STEPS), len(places)), bool),
        lattice=lattice,
        keys=keys,
        group=3 * keys.cube[:, None] + np.arange(3),
    )


@pytest.mark.parametrize(("clumps", "points"), [(3, 14), (5, 8), (6, 7)])
def test_a_fitted_frame_locks_by_chance_no_oftener_than_it_says(clumps, points):
    """Few groups, and seven parts of a correction that bring them to exact phases."""
    rng = np.random.default_rng(clumps)
    places = np.repeat(rng.uniform(-1.0, 1.0, (clumps, 3)), points, axis=0)
    places += rng.uniform(-2e-3, 2e-3, places.shape)
    told = []
    for _ in range(150):
        framed = framed_anywhere(places, PointLattice.keyed(Key(rng.bytes(32)), LABEL))
        lock = PointLock(
            log10_loose=0.0, framed=framed, choice=Choice(step=float(STEPS[9]), mode=2, share=1.0)
        )
        _, *corrected = lock.readings(1.0, np.array([0.5, 0.3, 0.2]))
        if corrected:  # enough coordinates carry, and a correction changes something
            told += [min(each.log10_chance + np.log10(each.hypotheses) for each in corrected)]
    assert len(told) > 50
    assert below(told, 0) <= 0.02, "what a fit gains is paid for"


def test_a_step_without_room_is_not_read():
    framed = drawn()[0]
    steps = {lock.choice.step for lock in framed.locks()}
    has_room = {float(step) for step, room in zip(STEPS, framed.room, strict=True) if room.any()}
    assert steps <= has_room
    assert has_room < set(STEPS.tolist())


def test_the_gradient_is_that_of_the_coordinates_under_a_small_pose():
    surface = surface_of(Mesh(*ball(2)))
    lattice = PointLattice.keyed(Key(bytes(32)), LABEL)
    framed = Framed.of(surface, Carried.of(surface, surface.frame), surface.frame, lattice)
    carries = framed.carrying(Choice(step=float(STEPS[6]), mode=2, share=1.0))
    assert carries.sum() > 100
    for direction in some(np.eye(7)):
        ends = []
        for sign in (1.0, -1.0):
            pose = Pose.turned(np.eye(3)).then(sign * 1e-6 * direction)
            ends.append((pose.scale * framed.points @ pose.turn + pose.shift)[carries])
        told = framed.gradient(carries) @ direction
        np.testing.assert_allclose((ends[0] - ends[1]) / 2e-6, told, atol=1e-6)


def test_the_first_few_are_those_with_the_lowest_draws():
    framed = drawn()[5]
    carries = framed.carrying(Choice(step=float(STEPS[2]), mode=2, share=1.0))
    few = framed.first(carries, 60)
    assert few.sum() <= 60 < carries.sum()
    assert (carries | ~few).all()
    assert framed.keys.draw[few].max() < framed.keys.draw[carries & ~few].min()
