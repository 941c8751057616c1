"""Each attack on a small model, and that its verdict can fail: it succeeds where the scheme is weaker."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from claims.security import __main__ as program
from claims.security import collusion, forgeries, oracle, pose, steganalysis
from claims.security.donors import Donor, forged, learnt
from claims.security.features import calibrated_features, plain_features
from claims.security.options import KEY, Options
from claims.security.pairs import phase_errors, pose_errors
from claims.security.point_phases import Cubes, cubes_of, errors_in_cubes
from claims.security.pose import energy_alone, energy_of_pair
from claims.security.steering import forged_on, warped
from claims.security.table import Figure, table
from claims.security.uniformity import uniformity
from claims.security.washing import bumps_at, moved_along, random_field, size_needed
from meshmark.coding.message import format_id
from meshmark.geometry.surface_of import surface_of
from meshmark.mesh import Mesh
from meshmark.ownership.carriers.lattice import Lattice
from meshmark.ownership.carriers.lattice_label import Label
from meshmark.ownership.embedding import embed
from meshmark.ownership.extraction import extract
from meshmark.ownership.points.point_lattice import PointLattice
from tests.counting import some
from tests.shapes import pebble

ACROSS = 30
SPACING = 0.25


def shape(stretch: float = 1.0) -> Mesh:
    points, faces = pebble(ACROSS)
    return Mesh(points * [1.0, 1.0, stretch], faces)


@pytest.fixture(scope="module")
def donor() -> Donor:
    made = Donor.of("pebble", shape(), 7)
    assert not made.mark.at_points
    return made


def lattice(number: int) -> Lattice:
    return Lattice.keyed(KEY, SPACING, Label(bytes([number]) * 16))


def moved_at(own: Lattice, rng: np.random.Generator) -> pose.Energy:
    """Return the energy of a mark in a lattice on a ball, of points on its surface and within."""
    places = rng.normal(size=(800, 3)) * 0.6
    inner = np.abs(own.coordinates(places) - np.round(own.coordinates(places))).max(axis=1) < 0.3
    weights = inner - inner.mean()
    return pose.Energy(places=places, weights=weights / len(places), spacing=SPACING, scale=0.03)


@pytest.mark.parametrize(("one", "holds"), [(True, False), (False, True)])
def test_a_lattice_for_all_models_is_found_and_one_for_each_is_not(monkeypatch, one, holds):
    monkeypatch.setattr(pose, "DIRECTIONS", 800)
    monkeypatch.setattr(pose, "STARTS", 2)
    monkeypatch.setattr("claims.security.pairs.FOLDS", 2)
    rng = np.random.default_rng(3)
    lattices = [lattice(0 if one else number) for number in range(8)]
    degrees, turns, random = pose_errors([moved_at(each, rng) for each in lattices], lattices, Options())
    assert uniformity(turns.ravel()).holds() == holds
    assert bool((degrees < 2.0).all() and (random > 2.0).any()) != holds


def test_uniform_phases_pass_and_others_do_not():
    rng = np.random.default_rng(1)
    phases = rng.uniform(size=500)
    assert uniformity(phases).holds()
    assert not uniformity(np.concatenate([phases, np.full(90, 0.3)])).holds()
    assert not uniformity(0.5 * np.round(2.0 * phases)).holds(), "two values leave Rayleigh's sum at 0"
    assert uniformity(np.zeros(9)).towards == 1.0


def test_a_mark_is_forged_on_what_was_warped_to_its_label_and_on_nothing_else(donor):
    near = warped(donor.original, 0.01, np.random.default_rng(1))
    made, suspect = forged_on(near, donor)
    assert made.off < 0.03
    assert extract(suspect, KEY, search="plain").ids == (donor.id,)
    plain = forged(shape(1.15), learnt(donor), donor.mark.step)
    assert extract(plain, KEY, search="plain").presence == "absent"


def test_phases_of_one_label_predict_each_other_and_of_two_do_not(donor):
    assert not uniformity(phase_errors(donor, [donor])).holds()
    other = replace(donor, mark=replace(donor.mark, label=Label(bytes(16))))
    errors = phase_errors(donor, [other])
    assert len(errors) > 20
    assert uniformity(errors).holds()


def test_phases_of_points_are_those_of_their_cubes_and_of_no_other_label():
    made = embed(Mesh(*pebble(20)), KEY, id=3)
    assert made.mark.at_points
    own = cubes_of(made.mesh, made.mark)

    def predicted(label: Label) -> Cubes:
        return Cubes(names=own.names, turns=PointLattice.keyed(KEY, label).keys(own.names).dither)

    errors = errors_in_cubes(own, predicted(made.mark.label))
    assert uniformity(errors).towards > 0.8
    assert uniformity(errors_in_cubes(own, predicted(Label(bytes(16))))).holds()
    assert len(errors) > 100


def test_the_energy_of_a_pair_is_strongest_along_its_lattice():
    own, before = lattice(4), Mesh(*pebble(44))
    surface = surface_of(before)
    nodes = np.unique(np.round(own.coordinates(surface.frame.to_canonical(surface.points))), axis=0)
    field = bumps_at(before, own.points(nodes), SPACING, np.random.default_rng(1))
    energy = energy_of_pair(before, moved_along(before, field, 1e-4), SPACING)
    turned = Rotation.random(200, random_state=1).as_matrix().reshape(-1, 3)
    found, others = (np.abs(energy.waves(axes)) for axes in (own.axes, turned))
    assert found.mean() > np.quantile(others, 0.95)
    alone = energy_alone(before, SPACING)
    assert np.isfinite(alone.weights).all()
    assert alone.weights.any()


def test_displacements_have_the_size_that_is_said(donor, monkeypatch):
    rng = np.random.default_rng(2)
    for field in some((random_field(donor.marked, 0.2, rng), bumps_at(donor.marked, np.eye(3), 0.9, rng))):
        moved = moved_along(donor.marked, field, 1e-3).vertices - donor.marked.vertices
        diagonal = np.linalg.norm(np.ptp(donor.marked.vertices, axis=0))
        assert np.sqrt((moved**2).sum(axis=1).mean()) / diagonal == pytest.approx(1e-3, rel=0.1)
    monkeypatch.setattr("claims.security.washing.has_id", lambda mesh, id: mesh < 0.3)
    monkeypatch.setattr("claims.security.washing.moved_along", lambda mesh, field, size: size)
    assert size_needed(donor.marked, 7, field, 1.0, 6) == pytest.approx(0.3, abs=1 / 64)


def test_colluders_are_counted_right_and_others_wrong(donor):
    copies = np.array([donor.marked.vertices, donor.original.vertices])
    made = list(collusion.suspects(donor.original, copies))
    assert [(group, mean) for group, mean, _ in made] == [(2, "average"), (2, "minimum"), (2, "maximum")]
    found = collusion.answer(donor.marked, [7, 8], group=2, mean="average", issued=[])
    assert (found.right, found.wrong) == (1, 0)
    found = collusion.answer(donor.marked, [8, 9], group=2, mean="average", issued=[])
    assert (found.right, found.wrong) == (0, 1)


def test_innocents_are_named_where_the_limit_is_none(donor, monkeypatch):
    seen = collusion._readings(donor.marked)
    assert collusion.innocents(seen, 3, Options()).met
    monkeypatch.setattr(collusion, "PROVEN_LOG10", 0.0)
    assert collusion.innocents(seen, 3, Options()).met is False


@pytest.fixture
def climber(donor, monkeypatch) -> oracle.Climber:
    """The attack on an oracle that loses the id as soon as points of a third of the model are moved enough."""
    asked = oracle.Oracle(marked=donor.marked, id=donor.id)
    weak = donor.marked.vertices[:, 0] > np.quantile(donor.marked.vertices[:, 0], 0.67)

    def said(mesh: Mesh) -> str:
        moved = np.sqrt(((mesh.vertices - donor.marked.vertices)[weak] ** 2).sum(axis=1).mean())
        ids = (
            [] if moved > 2.0 * donor.rms * np.linalg.norm(np.ptp(mesh.vertices, axis=0)) else [format_id(7)]
        )
        return json.dumps({"ids": ids, "log10_false_positive": -30.0})

    monkeypatch.setattr(oracle, "answered", said)
    return oracle.Climber(donor, asked, np.random.default_rng(4))


def test_the_oracle_is_climbed_to_where_the_id_is_lost_for_less(climber, donor):
    climber.climb(40, np.inf)
    first = climber.size
    climber.climb(600, np.inf)
    assert first < oracle.LARGEST
    assert climber.size < 0.9 * first
    assert 600 <= climber._oracle.queries < 700


def test_evidence_of_the_true_pose_shows(climber, donor):
    near = donor.lattice.coordinates(climber.places[climber.centres])
    climber.evidence = np.cos(2.0 * np.pi * near).sum(axis=1) + 3.0
    assert oracle.pose_chance(climber, donor, np.random.default_rng(5), 200) < 0.01
    climber.evidence = np.random.default_rng(6).normal(size=len(near))
    assert oracle.pose_chance(climber, donor, np.random.default_rng(5), 200) > 0.01


def test_forgeries_that_are_accepted_miss_the_bar(monkeypatch):
    class Lax:
        def __init__(self, subject: object) -> None:
            self.parts, self.lone, self.harmless = {"a part": None}, {"a mark": None}, 0

        def accepted(self, change: object, count: int, rng: object) -> int:
            return count // 5

    monkeypatch.setattr(forgeries, "Watching", Lax)
    subject = SimpleNamespace(name="pebble", rng=lambda kind: None)
    rows = list(forgeries.measured(subject, "web", 10))
    assert [(row.accepted, row.tries) for row in rows] == [(2, 10), (2, 10)]
    assert [row.met for row in some(forgeries._figures(rows))] == [False, False]
    none = [replace(row, accepted=0) for row in rows]
    assert all(row.met for row in some(forgeries._figures(none)))


def test_what_moves_nothing_that_is_watched_is_no_forgery(monkeypatch):
    forger = object.__new__(forgeries.Watching)
    forger.surface = SimpleNamespace(points=np.zeros((3, 3)))
    forger.vouching = SimpleNamespace(sure=np.array([True, True, False]), typical_step=0.1)
    monkeypatch.setattr(forgeries.Forger, "authentic", lambda self, points: bool((points < 9.0).all()))
    moved = [0.3 * np.eye(3), 0.3 * np.eye(3)[[2, 2, 0]], np.diag([0.05, 0.05, 0.3]), 9.0 * np.eye(3)]
    assert [forger.authentic(each) for each in moved] == [True, True, False, False]
    assert forger.harmless == 1


@pytest.mark.parametrize("judge", [steganalysis.judged_by_regression, steganalysis.judged_by_kernel])
def test_detectors_see_what_is_there_and_nothing_else(judge):
    rng = np.random.default_rng(8)
    labels, names = np.tile([0.0, 1.0, 1.0], 12), np.repeat(np.arange(12), 3)
    values = rng.normal(size=(36, 5))
    assert abs(steganalysis.area(values, labels, names, judge) - 0.5) < 0.25
    values[:, 2] += 4.0 * labels
    assert steganalysis.area(values, labels, names, judge) > 0.95


def test_features_are_of_the_shape_and_see_noise():
    mesh = shape()
    noisy = mesh.with_vertices(
        mesh.vertices + 1e-3 * np.random.default_rng(1).normal(size=mesh.vertices.shape)
    )
    for features in some((plain_features, calibrated_features)):
        found = features(mesh)
        moved = features(mesh.with_vertices(3.0 * mesh.vertices + 1.0))
        assert np.isfinite(found).all()
        assert np.median(np.abs(moved - found)) < 1e-3 < np.median(np.abs(features(noisy) - found))


@pytest.mark.parametrize(("met", "code"), [(True, 0), (None, 0), (False, 1)])
def test_the_command_prints_its_table_and_fails_with_a_bar(met, code, monkeypatch, capsys):
    asked = []

    def attack(options: Options) -> list[Figure]:
        asked.append(options)
        return [Figure(name="removed", measured="2", of="3 models", bar="0", met=met)]

    monkeypatch.setattr(collusion, "collusion", attack)
    assert program.main(["collusion", "--models", "3", "--split", "test"]) == code
    assert (asked[0].models, asked[0].split, asked[0].count(20)) == (3, "test", 3)
    assert table(attack(asked[0])) in capsys.readouterr().out
