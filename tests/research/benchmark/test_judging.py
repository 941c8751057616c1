"""Marking and judging in this process: what the attacker is given, and what the truth is."""

from __future__ import annotations

import numpy as np
import pytest

from meshmark.errors import InputError
from meshmark.research import SCHEMES
from meshmark.research.benchmark.run.job import Mark, mark_of, marks_of
from meshmark.research.benchmark.run.judging import judge
from meshmark.research.benchmark.run.marked_model import key_of, look, mark, original, payload_of
from meshmark.research.benchmark.run.marked_models import (
    MARKED,
    clear_unfinished,
    load_mark,
    mark_path,
    save_mark,
)
from meshmark.research.benchmark.run.row import Case
from meshmark.research.schemes.scheme import Readout

MODEL = "train/even.ply"


def case(attack, trial="marked", scheme="toy", **more):
    return Case("security", scheme, MODEL, "standard", attack, trial, 3, **more)


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """Leave out the measures of distortion that take long."""

    class Quick:
        def to_dict(self):
            return {"rms_over_diagonal": 0.5, "a measure that rows do not have": 1.0}

    monkeypatch.setattr("meshmark.research.benchmark.run.marked_model.compare", lambda a, b: Quick())


@pytest.fixture
def judged(toys, models, tmp_path):
    """Mark what a case needs, and judge it."""

    def go(each):
        statuses = {mark(models, tmp_path, wanted).status for wanted in marks_of(each)}
        assert statuses <= {"ok"}
        return judge(models, tmp_path, each).figures

    return go


def test_a_mark_carries_its_payload_under_its_key(toys, models, tmp_path):
    marks = [mark_of(case("none")), *marks_of(case("collusion:3"))[1:], *marks_of(case("copy:1", "forged"))]
    for each in marks:
        figures = mark(models, tmp_path, each).figures
        assert figures["embed_seconds"] > 0
        assert ("rms_over_diagonal" in figures) == (each == marks[0]), "the distortion of one mark is enough"
        found = SCHEMES["toy"].extract(load_mark(tmp_path, each), key_of(each))
        np.testing.assert_array_equal(found.bits, payload_of(each, 16))
        assert found.present
    assert len({payload_of(each, 16).tobytes() for each in marks}) == len(marks)
    assert len({key_of(each) for each in marks}) == 1, "one owner, one key"


@pytest.mark.parametrize(
    "change", [{"scheme": "informed"}, {"owner": "other"}, {"budget": "subtle"}, {"seed": 4}, {"fresh": 1}]
)
def test_another_mark_has_another_key_payload_and_file(change, tmp_path):
    first = Mark(scheme="toy", owner=MODEL, budget="standard", seed=3)
    other = Mark(**{**vars(first), **change})
    assert key_of(first) != key_of(other)
    assert payload_of(first, 64).tobytes() != payload_of(other, 64).tobytes()
    assert mark_path(tmp_path, first) != mark_path(tmp_path, other)


def test_colluders_are_judged_by_the_nearest_of_them(judged):
    figures = judged(case("collusion:3"))
    assert 0.0 <= figures["ber"] < 0.5
    assert figures["recovered"] == (figures["present"] and figures["ber"] == 0.0)


def test_a_second_mark_has_its_own_key_and_payload(judged, monkeypatch):
    seen = []
    toy = type(SCHEMES["toy"])
    embed = toy.embed
    monkeypatch.setattr(toy, "embed", lambda *a, **k: seen.append((a[2].tobytes(), a[3])) or embed(*a, **k))
    figures = judged(case("second_mark:1"))
    (first_bits, first_key), (second_bits, second_key) = seen
    assert first_bits != second_bits
    assert first_key != second_key
    assert figures["present"] is False, "this toy does not survive it"


def test_a_forgery_starts_from_the_model_that_was_never_marked(judged, models, monkeypatch):
    given = []
    apply = "meshmark.attacks.attack.Attack.apply"
    real = __import__("meshmark.attacks.attack", fromlist=["Attack"]).Attack.apply
    monkeypatch.setattr(apply, lambda self, *a: given.append(a) or real(self, *a))
    figures = judged(case("copy:1", "forged"))
    mesh, _, _, held = given[0]
    np.testing.assert_array_equal(mesh.vertices, original(models, MODEL).vertices)
    assert held.donor is not None
    assert held.copies == ()
    assert figures["present"] is False


def test_schemes_budgets_and_trials_meet_the_same_attack(judged, monkeypatch):
    seen = []
    monkeypatch.setattr(
        "meshmark.research.benchmark.run.judging.generator_for",
        lambda *parts: seen.append(parts) or np.random.default_rng(0),
    )
    for each in (
        case("noise:0.001"),
        case("noise:0.001", "wrong key"),
        case("noise:0.001", "unmarked", scheme="informed"),
        case("noise:0.001", repeat=1),
        case("noise:0.002"),
    ):
        judged(each)
    assert len(seen) == 5
    assert len(set(seen)) == 3


class Coded:
    """Sees three of four code bits, one of them wrongly."""

    title, source, bits, blind = "Coded", "tests", 2, True

    def code(self, bits, key):
        return np.concatenate([bits, bits]).astype(np.uint8)

    def embed(self, mesh, bits, key, *, strength="standard"):
        self.sent = bits
        return mesh

    def extract(self, mesh, key, *, reference=None):
        raw = np.where(self.code(self.sent, key) == 1, -2.0, 0.5)
        raw[0], raw[1] = 0.0, -raw[1]
        return Readout(bits=self.sent.copy(), present=True, log10_false_positive=-9.0, raw=raw)


def test_raw_errors_count_the_code_bits_that_were_seen(models, tmp_path, monkeypatch):
    schemes = {"coded": Coded()}
    for module in ("marked_model", "judging"):
        monkeypatch.setattr(f"meshmark.research.benchmark.run.{module}.SCHEMES", schemes)
    each = case("none", scheme="coded")
    mark(models, tmp_path, mark_of(each))
    figures = judge(models, tmp_path, each).figures
    assert figures["raw_ber"] == pytest.approx(1 / 3)
    assert figures["ber"] == 0.0
    assert figures["recovered"] is True
    assert figures["log10_false_positive"] == -9.0
    assert figures["vertices_per_second"] == pytest.approx(614 / figures["extract_seconds"])


def test_a_look_tells_the_size(models):
    figures = look(models, type("L", (), {"model": MODEL})()).figures
    assert (figures["points"], figures["size_class"]) == (614, "500-2,500")
    assert figures["file_seconds"] > 0


def test_a_model_that_is_gone_is_an_input_error(models):
    with pytest.raises(InputError):
        original(models, "no/such.off")


def test_a_mark_is_kept_whole_or_not_at_all(models, tmp_path, monkeypatch):
    each, mesh = Mark(scheme="toy", owner=MODEL, budget="standard", seed=3), original(models, MODEL)
    monkeypatch.setattr("numpy.savez", lambda file, **_: file.write(b"half") and 1 / 0)
    with pytest.raises(ZeroDivisionError):
        save_mark(tmp_path, each, mesh)
    assert not mark_path(tmp_path, each).exists()
    assert list((tmp_path / MARKED).iterdir())
    clear_unfinished(tmp_path)
    assert not list((tmp_path / MARKED).iterdir())
    monkeypatch.undo()
    save_mark(tmp_path, each, mesh)
    again = load_mark(tmp_path, each)
    np.testing.assert_array_equal(again.vertices, mesh.vertices)
    np.testing.assert_array_equal(again.faces, mesh.faces)
