"""Poses compose as similarities do, and their gradient is that of the measured offsets."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.coding.keyed import rotation
from meshmark.coding.keys import Key
from meshmark.geometry.frame import canonical_frame
from meshmark.geometry.sampling import plan_samples
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.carriers.nodes import find_nodes
from meshmark.ownership.carriers.pose import POSE_SIZE, Pose, pose_gradient
from meshmark.ownership.parameters import LONGEST_SAMPLE
from meshmark.ownership.search.measurement import place, read_cells
from tests.shapes import pebble

LABEL = Label(bytes(16))
LATTICE = Lattice.keyed(Key(b"k" * 32), 0.25, LABEL)


@pytest.fixture(scope="module")
def samples():
    points, faces = pebble(144)
    canonical = canonical_frame(points, faces).to_canonical(points)
    return plan_samples(canonical, faces, LONGEST_SAMPLE * LATTICE.spacing)(canonical)


def moved(points, pose):
    return pose.scale * points @ pose.turn + pose.shift


def test_small_steps_are_shift_scale_and_turn():
    step = 1e-6 * np.arange(1.0, 1.0 + POSE_SIZE)
    points = np.random.default_rng(0).normal(size=(20, 3))
    after = moved(points, Pose.turned(np.eye(3)).then(step))
    expected = points * (1.0 + step[3]) + np.cross(step[4:], points) + step[:3]
    np.testing.assert_allclose(after, expected, atol=1e-9)


def test_a_pose_after_a_pose_is_one_pose():
    rng = np.random.default_rng(1)
    start, step = (
        Pose(turn=rotation(b"a" * 32), scale=1.3, shift=rng.normal(size=3)),
        rng.normal(size=POSE_SIZE),
    )
    points = rng.normal(size=(20, 3))
    alone = Pose.turned(np.eye(3)).then(step)
    np.testing.assert_allclose(
        moved(points, start.then(step)), moved(moved(points, start), alone), atol=1e-12
    )
    assert np.linalg.det(alone.turn) == pytest.approx(1.0)


@pytest.mark.parametrize("part", range(POSE_SIZE))
def test_offsets_follow_the_gradient(samples, part):
    start = Pose.turned(rotation(b"t" * 32))
    cells = read_cells(samples, LATTICE, start)
    size = 1e-3
    step = size * np.eye(POSE_SIZE)[part]
    after = place(samples, LATTICE, start.then(step))
    row = find_nodes(after.nodes, cells.nodes)
    assert (row >= 0).all()
    change = (after.offset[row] - cells.offset) / size
    gradient = pose_gradient(cells, LATTICE)[:, part]
    # The patch itself changes a little as the window slides over relief; the gradient leaves that out.
    assert np.corrcoef(change, gradient)[0, 1] > 0.97
    assert np.sqrt(np.mean((change - gradient) ** 2)) < 0.3 * np.sqrt(np.mean(gradient**2))
