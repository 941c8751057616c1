"""Points far from small rings: how much errors move their marks, and that such marks are not relied on."""

from __future__ import annotations

import numpy as np

from meshmark.attacks import parse_chain
from meshmark.authentication.checks.rounded_marks import unread_when_rounded
from meshmark.authentication.examination import examine
from meshmark.authentication.marks.plan import mark, plan
from meshmark.authentication.marks.precision import precision_of
from meshmark.authentication.marks.ring_room import RingRoom
from meshmark.authentication.marks.ring_shapes import frames, ring_shapes
from meshmark.authentication.marks.rings_of import rings_of
from meshmark.authentication.parameters import FINE
from meshmark.coding.keys import Key
from meshmark.geometry.weld import weld
from meshmark.marking import embed
from meshmark.mesh import Mesh
from tests.counting import some

KEY = Key(bytes(range(32)))
# A spindle: two triangles, one turned against the other, each closed by a tip; its faces.
FACES = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [4, 6, 5], [4, 7, 6], [4, 5, 7]]
FACES += [[1, 5, 2], [2, 5, 6], [2, 6, 3], [3, 6, 7], [3, 7, 1], [1, 7, 5]]


def spindles(count: int, far: float) -> Mesh:
    """Spindles of random shapes and places whose tips lie `far` ring sizes from their rings."""
    random = np.random.default_rng(5)
    points, faces = [], []
    for number in range(count):
        turn = random.uniform(0.0, 1.0) + np.arange(3) * 2.0 * np.pi / 3.0
        rings = [
            np.stack([np.cos(turn + shift), np.sin(turn + shift), np.full(3, height)], axis=1)
            for shift, height in ((0.0, 0.0), (np.pi / 3.0, -random.uniform(0.5, 1.5)))
        ]
        tips = [[[1.0, 2.0, far]], [[-2.0, 0.5, -far]]]
        spindle = np.concatenate([tips[0], rings[0], tips[1], rings[1]])
        spindle += random.normal(0.0, 0.1, spindle.shape)
        points.append(spindle * random.uniform(0.5, 1.5) + random.uniform(-300.0, 300.0, 3))
        faces.append(np.array(FACES) + 8 * number)
    return Mesh(np.concatenate(points), np.concatenate(faces))


def test_the_swing_of_a_point_is_what_errors_of_its_ring_make_of_it():
    surface = weld(spindles(20, 12.0))
    random = np.random.default_rng(1)
    ratios: list[float] = []
    for rings in rings_of(surface):
        shapes = ring_shapes(surface.points, rings)
        rows = np.arange(len(rings.vertex))
        predicted = shapes.swing
        small = 1e-5 * shapes.size
        places = []
        for _ in range(400):
            points = surface.points.copy()
            moved = random.normal(size=points.shape)
            points[rings.around] += small[:, None, None] * moved[rings.around]
            again = ring_shapes(points, rings)
            lead = shapes.distance.argmax(axis=1)
            order = (lead[:, None] + np.arange(rings.around.shape[1])) % rings.around.shape[1]
            axes = frames(again.offsets(rows, order), again.normal)
            out = (surface.points[rings.vertex] - again.centre) / again.size[:, None]
            places.append(np.einsum("rij,rj->ri", axes, out))
        # The centre moves, too, which the spread itself takes into account.
        square = np.var(places, axis=0) / 1e-10 - 1.0 / rings.around.shape[1]
        found = np.sqrt(square.max(axis=1).clip(min=0.0)) / shapes.spread
        alone = _once(rings.around, len(surface.points)) & (predicted > 1.0)
        ratios += (found[alone] / predicted[alone]).tolist()
    for ratio in some(ratios, least=20):
        assert 0.8 < ratio < 1.25


def _once(around, count):
    """Whether no point of a ring is moved for another ring of the list, too."""
    times = np.bincount(around.ravel(), minlength=count)
    return (times[around] == 1).all(axis=1)


def test_far_tips_of_small_rings_are_vouched_for_by_their_neighbours():
    mesh = spindles(250, 12.0)
    surface = weld(mesh)
    made = plan(surface, KEY, precision_of(mesh))
    far = ~RingRoom.of(surface, made.unit, FINE).firm
    assert far.sum() > 300
    assert not far[made.marks].any()
    chosen = np.zeros(len(far), bool)
    chosen[made.marks] = True
    able = RingRoom.of(surface, made.unit, FINE).allowed(made.layout.levels)
    near = surface.connectivity.graph @ chosen.astype(np.float64) > 0.0
    assert near[far & able].all()


def test_a_model_with_far_tips_stays_authentic_wherever_it_is_put():
    marked = embed(spindles(250, 12.0), KEY, id=5, layers="authentication", payload="none").mesh
    for seed in some(range(6)):
        turned = parse_chain("similarity:1+float32:1")(marked, np.random.default_rng(seed))
        assert not examine(turned, KEY).altered.any()


def test_a_marked_point_that_is_pulled_far_out_is_altered():
    marked = embed(spindles(250, 1.0), KEY, id=5, layers="authentication", payload="none").mesh
    whole = examine(marked, KEY)
    assert not whole.altered.any()
    for point in some(np.flatnonzero(whole.checks.passed)[::60]):
        spike = marked.vertices.copy()
        spike[whole.surface.point_of_vertex == point] += np.array([20.0, 30.0, 40.0])
        assert examine(marked.with_vertices(spike), KEY).altered[point]


def test_marks_that_swing_are_not_taken_for_readable():
    mesh = spindles(250, 12.0)
    surface = weld(mesh)
    made = plan(surface, KEY, precision_of(mesh))
    tips = np.zeros(len(surface.points), bool)
    tips[surface.point_of_vertex[::4]] = True
    forced = type(made)(
        surface=surface,
        found=RingRoom.of(surface, made.unit, FINE).found(tips, KEY, made.layout),
        style=made.style,
        layout=made.layout,
        unit=made.unit,
        covered=0.0,
    )
    done = mark(forced, KEY, 5, lambda index: (index & np.uint32(15)).astype(np.uint16))
    _, failing = unread_when_rounded(forced, done, done.points, KEY, FINE)
    swing = np.zeros(len(tips))
    swing[forced.marks] = forced.found.swing
    assert (failing == (swing >= 2.0)).all()
    assert failing.sum() > 100
