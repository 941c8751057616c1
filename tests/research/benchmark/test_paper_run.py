"""What the paper's suite asks of a run: probes beside the cases, an end in time, and attacked models compared."""

from __future__ import annotations

import shutil
from dataclasses import replace
from itertools import count

import numpy as np
import pytest

from meshmark.attacks.attack import Attacked
from meshmark.errors import InputError
from meshmark.mesh import Mesh
from meshmark.metrics.psnr import psnr_db
from meshmark.research import SCHEMES
from meshmark.research.ablation.modules import SALIENCY
from meshmark.research.benchmark.run import run as runs
from meshmark.research.benchmark.run.job import Outcome, Probe
from meshmark.research.benchmark.run.judging import attacked_psnr_db
from meshmark.research.benchmark.run.model_files import choose, find_models, spread
from meshmark.research.benchmark.run.probes import PROBES, probe
from meshmark.research.benchmark.run.run import Finished, Plan, run, schemes_of
from meshmark.research.benchmark.run.store import Store
from meshmark.research.benchmark.run.suites import SUITES, Part
from tests.counting import some
from tests.research.benchmark import toy_schemes
from tests.shapes import pebble

BRIEF = replace(
    SUITES["smoke"], parts=(Part(attacks=("none",)),), schemes=("toy", "absent"), probes=("salient points",)
)


@pytest.fixture
def brief(monkeypatch):
    """A suite of one case and one probe."""
    monkeypatch.setitem(SUITES, "smoke", BRIEF)


@pytest.mark.usefixtures("toys", "brief")
def test_probes_are_made_once_and_kept(models, tmp_path):
    told = []
    first = run(Plan(suite="smoke", data=models, out=tmp_path, workers=1), lambda *all: told.append(all))
    assert told[-1] == (6, 6, 0), "a case and a probe for each of three models"
    assert [probe.model for probe in first.probes] == ["test/deep/odd.off", "tiny.obj", "train/even.ply"]
    assert all(outcome.figures.keys() == SALIENCY.keys() for outcome in some(first.probes.values()))
    assert all(outcome.figures["nc_dgg"]["seconds"] > 0 for outcome in some(first.probes.values()))
    assert first.left == 0
    again = run(Plan(suite="smoke", data=models, out=tmp_path, workers=1), lambda *all: told.append(all))
    assert len(told) == 6
    assert again.resumed == 6
    assert again.probes == first.probes


@pytest.mark.usefixtures("toys", "brief")
def test_when_the_time_is_over_what_was_begun_is_ended_and_the_rest_is_left(models, tmp_path):
    plan = Plan(suite="smoke", data=models, out=tmp_path, workers=1, hours=1.0)

    def late(after: int) -> Finished:
        """Run with a clock that says, from so many looks at it on, that all the time has gone."""
        looks = count()
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(runs, "perf_counter", lambda: 0.0 if next(looks) < after else 1e9)
            return run(plan)

    none = late(1)
    assert (len(none.rows), len(none.probes), none.left) == (0, 0, 6)
    some = late(2)
    assert {row.case.model for row in some.rows} == {probe.model for probe in some.probes}
    assert (len(some.rows), some.left) == (1, 4)
    whole = run(replace(plan, hours=None))
    assert (len(whole.rows), len(whole.probes), whole.left) == (3, 3, 0)


def test_a_probe_that_cannot_be_falls_with_its_model(tmp_path):
    with Store(tmp_path) as store:
        store.add_job(Probe(kind="regions", model="a", seed=0), Outcome(status="refused", note="too small"))
        store.add_job(
            Probe(kind="carriers", model="b", seed=0), Outcome(status="ok", figures={"x": {"y": [1.0, 2.0]}})
        )
        found = store.probes()
    assert found[Probe(kind="carriers", model="b", seed=0)].figures == {"x": {"y": [1.0, 2.0]}}
    assert found[Probe(kind="regions", model="a", seed=0)].note == "too small"


@pytest.mark.usefixtures("toys", "brief")
def test_a_model_that_cannot_be_read_fails_its_probes_too(tmp_path):
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "broken.off").write_text("OFF\n1 1\n")
    found = run(Plan(suite="smoke", data=tmp_path / "models", out=tmp_path / "out", workers=1))
    assert [outcome.status for outcome in found.probes.values()] == ["failed"]
    assert [row.status for row in found.rows] == ["failed"]
    assert found.left == 0


def test_probes_depend_on_seed_and_model_alone(models):
    name = "train/even.ply"
    one, same = (
        probe(models, Probe(kind="salient points", model=name, seed=1)).figures["random"]["points"]
        for _ in range(2)
    )
    assert one == same
    assert set(SUITES["paper"].probes) == set(PROBES)


def test_any_first_models_are_a_sample(models):
    names = find_models(models)
    order = spread(models, names)
    assert sorted(order) == sorted(names)
    for limit in some(range(1, len(names) + 1)):
        assert choose(models, names, limit) == sorted(order[:limit])


@pytest.mark.usefixtures("toys")
def test_a_plan_without_schemes_has_those_of_the_suite_that_are_there(models, tmp_path, brief):
    assert schemes_of(Plan(suite="smoke", data=models, out=tmp_path)) == ("toy",)
    assert schemes_of(Plan(suite="speed", data=models, out=tmp_path)) == ("ncdg_lv",)
    assert schemes_of(Plan(suite="smoke", data=models, out=tmp_path, schemes=("toy", "all")))[0] == "toy"
    assert set(schemes_of(Plan(suite="smoke", data=models, out=tmp_path, schemes=("all",)))) == set(SCHEMES)


@pytest.mark.parametrize("hours", [0.0, -1.0])
def test_no_time_is_refused(models, tmp_path, hours):
    with pytest.raises(InputError, match="expected more than 0"):
        run(Plan(suite="smoke", data=models, out=tmp_path, hours=hours))


def test_a_scheme_in_a_file_is_measured_and_a_changed_one_is_another_run(models, tmp_path, brief):
    path = tmp_path / "toy.py"
    text = (shutil.copy(toy_schemes.__file__, path), path.read_text())[1]
    path.write_text(text[: text.index("class Crashing")])
    plan = Plan(suite="smoke", data=models, out=tmp_path / "out", schemes=(str(path),), limit=1, workers=1)
    (row,) = run(plan).rows
    assert (row.case.scheme, row.status, row.ber) == (str(path), "ok", 0.0)
    path.write_text(path.read_text().replace("SMALLEST = 100", "SMALLEST = 101"))
    with pytest.raises(InputError, match="holds a run with the schemes"):
        run(plan)


def test_the_psnr_of_an_attacked_model_is_that_of_what_is_left():
    whole = Mesh(*pebble())
    rng = np.random.default_rng(0)
    moved = whole.with_vertices(whole.vertices + rng.normal(0.0, 0.01, whole.vertices.shape))
    number = len(whole.vertices)
    assert attacked_psnr_db(whole, Attacked(mesh=moved, origin=np.arange(number))) == pytest.approx(
        psnr_db(whole, moved)
    )
    order = rng.permutation(number)
    shuffled = Mesh(moved.vertices[order], np.argsort(order)[whole.faces])
    assert attacked_psnr_db(whole, Attacked(mesh=shuffled, origin=order)) == pytest.approx(
        psnr_db(whole, moved)
    )
    left = np.sort(rng.choice(number, number // 3, replace=False))
    part = Mesh(moved.vertices[left], np.zeros((0, 3), np.int64))
    square = np.sum((moved.vertices[left] - whole.vertices[left]) ** 2) / len(left)
    diagonal = np.linalg.norm(np.ptp(whole.vertices, axis=0))
    expected = 20 * np.log10(diagonal / np.sqrt(square))
    assert attacked_psnr_db(whole, Attacked(mesh=part, origin=left)) == pytest.approx(expected)
    assert attacked_psnr_db(whole, Attacked(mesh=moved, origin=None)) is None
    assert attacked_psnr_db(whole, Attacked(mesh=moved, origin=np.full(number, -1))) is None
