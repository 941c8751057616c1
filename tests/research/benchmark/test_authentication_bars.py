"""Every bar on one tiny model: each row is there, a planted failure counts as one, and the table says so."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import meshmark as mm
from claims.authentication import __main__ as program
from claims.authentication import benign, payloads, points, ranking, restoring, tampering
from claims.authentication.figures import FIGURES, SECONDS, Row, append, load_rows, table
from claims.authentication.subjects import KEY, Subject
from meshmark.mesh import Mesh
from meshmark.research.training.region_trials import region_trials
from tests.shapes import pebble

BENIGN = {
    "authentic after a benign operation",
    "authentic after six significant digits",
    "PSNR of the layer alone",
}
EDITED = {
    "altered after a local edit", "IoU at 2 % and more", "recall at 2 % and more",
    "untouched regions called altered",
}  # fmt: skip
PAYLOADS = {
    "payload at 55 % of the marks, bits per point", "image byte by byte", "PSNR with both layers",
    "1 bit per point read from a connected 60 % of the surface",
    "1 bit per point read from a connected 60 % of the points",
    "half of that from 40 % of the marks, scattered", "half of that from 40 % of all points, scattered",
}  # fmt: skip
# As few points as tell the whole id by their marks, also with a part altered: about 2,000.
ACROSS = 64
RECOVERED = {"recovered at all", "RMS after recovery, % of the diagonal", "times smaller than before"}


def longer() -> Mesh:
    points, faces = pebble(ACROSS)
    return mm.embed(
        Mesh(points * [1.0, 1.0, 1.4], faces), KEY, id=9, layers="authentication", payload="none"
    ).mesh


@pytest.fixture(scope="module")
def subject() -> Subject:
    found = Subject("pebble", Mesh(*pebble(ACROSS)), longer)
    assert found.marked.layers == "both"
    return found


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """One operation and one size of edits; what is measured many times is measured once."""
    monkeypatch.setattr(benign, "benign_operations", lambda mesh, rng: [("nothing", mesh)])
    monkeypatch.setattr(benign, "_attributes", lambda mesh: [])
    for module in (tampering, restoring):
        monkeypatch.setattr(module, "SHARES", (0.05,))
        monkeypatch.setattr(module, "EDITS", ("dent",))


def figures(rows: list[Row]) -> set[str]:
    return {row.figure for row in rows}


def misses(rows: list[Row]) -> set[str]:
    """Return the figures that the table calls missed."""
    lines = [line.split(" | ") for line in table(rows)[0].splitlines() if line.endswith("**no** |")]
    return {line[1] for line in lines}


def test_benign_rows(subject, monkeypatch):
    rows = list(benign.measure(subject, None))
    assert figures(rows) == BENIGN
    assert {row.value for row in rows if row.figure.startswith("authentic after a")} == {True}
    monkeypatch.setattr(mm, "authenticate", lambda mesh, key: _Found("altered"))
    assert misses(list(benign.measure(subject, None))) >= BENIGN - {"PSNR of the layer alone"}


def test_edit_rows(subject, monkeypatch):
    rows = list(tampering.measure(subject, 1))
    assert figures(rows) == EDITED
    assert "altered after a local edit" not in misses(rows)
    honest = mm.authenticate
    blind = _stands_in(
        honest, lambda found: replace(found, verdict="authentic", altered=found.altered & False)
    )
    monkeypatch.setattr(mm, "authenticate", blind)
    assert misses(list(tampering.measure(subject, 1))) >= EDITED - {"untouched regions called altered"}


def test_paste_rows(subject, monkeypatch):
    rows = list(tampering.measure_pastes(subject, None))
    assert figures(rows) == {"pasted part flagged", "share of the pasted part in the map"}
    assert {row.detail for row in rows} == {
        f"{kind} 5 %" for kind in ("another model", "another place", "another id")
    }
    assert misses(rows) == set()
    honest = mm.authenticate
    elsewhere = _stands_in(honest, lambda found: replace(found, altered=~found.altered))
    monkeypatch.setattr(mm, "authenticate", elsewhere)
    assert misses(list(tampering.measure_pastes(subject, None))) == figures(rows)


def test_move_rows(subject, monkeypatch):
    rows = list(points.measure_moves(subject, 20))
    assert {(row.figure, row.trials) for row in rows} == {
        ("one point moved by 1 to 2 steps, seen", 20),
        ("ten points so moved, seen", 2),
    }
    assert misses(rows) == set()
    monkeypatch.setattr(points, "altered_points", lambda surface, checks: np.zeros(len(surface.points), bool))
    assert misses(list(points.measure_moves(subject, 20))) == figures(rows)


def test_payload_rows(subject, monkeypatch):
    monkeypatch.setattr(mm, "embed", _once(mm.embed, "layers"))
    rows = list(payloads.measure(subject, None))
    assert figures(rows) == PAYLOADS
    assert [row.value for row in rows if row.figure == "image byte by byte"] == [True]
    monkeypatch.setattr(mm, "authenticate", lambda mesh, key: _Found("authentic"))
    assert misses(list(payloads.measure(subject, None))) >= {name for name in PAYLOADS if "b" in name[:10]}

    def refuse(*_: object, **__: object) -> None:
        raise mm.CapacityError("too long")

    monkeypatch.setattr(mm, "embed", refuse)
    assert "image byte by byte" in misses(list(payloads.measure(subject, None)))


def test_recovery_rows(subject, monkeypatch):
    rows = list(restoring.measure(subject, 1))
    assert figures(rows) == RECOVERED
    assert "recovered at all" not in misses(rows)
    honest = mm.recover
    monkeypatch.setattr(mm, "recover", _stands_in(honest, lambda found: replace(found, mesh=None)))
    assert misses(list(restoring.measure(subject, 1))) == {"recovered at all"}


def test_unmark_rows(subject, monkeypatch):
    rows = list(restoring.measure_unmark(subject, None))
    assert figures(rows) == {"largest error after unmark, over the diagonal"}
    assert misses(rows) == set()
    off = _stands_in(restoring.unmark, lambda found: replace(found, mesh=subject.marked.mesh))
    monkeypatch.setattr(restoring, "unmark", off)
    assert misses(list(restoring.measure_unmark(subject, None))) == figures(rows)


def test_roc_rows(subject, monkeypatch):
    monkeypatch.setattr(ranking, "region_trials", _once(lambda *given: list(region_trials(*given))))
    rows = list(ranking.measure(subject, 2))
    assert figures(rows) == {"ROC area of the network", "ROC area of the binomial rule"}
    assert {row.detail for row in rows} == {"touched", "untouched"}
    text, _ = table(rows)
    assert f"the rule's | 1 | {'yes' if 'ROC area of the network' not in misses(rows) else '**no**'}" in text
    honest = ranking.region_scores

    def worse(trials: list[object]) -> tuple[np.ndarray, ...]:
        rule, network, touched = honest(trials)
        return rule, -network, touched

    monkeypatch.setattr(ranking, "region_scores", worse)
    assert misses(list(ranking.measure(subject, 2))) == {"ROC area of the network"}


def test_a_forgery_that_passes_is_a_miss():
    rows = [Row("forged parts accepted", "a", "part edited", 0.0, 999)]
    assert misses(rows) == set()
    assert misses([*rows, Row("forged parts accepted", "a", "brush", 1 / 1000, 1000)]) == {
        "forged parts accepted"
    }
    assert misses([Row("lone marks guessed, accepted", "a", "", 0.001, 1000)]) == set()


def test_rates_add_up_over_trials_and_areas_over_models(tmp_path):
    rows = [
        Row("pasted part flagged", "a", "x", 1.0, 30),
        Row("pasted part flagged", "b", "y", 0.9, 10),
        Row("ROC area of the network", "a", "touched", 2.0),
        Row("ROC area of the network", "b", "touched", 0.5),
        Row("ROC area of the network", "b", "untouched", 1.0),
        Row("ROC area of the binomial rule", "a", "touched", 2.0),
        Row("ROC area of the binomial rule", "a", "untouched", 1.0),
        Row(SECONDS, "a", "edits", 3.0),
        Row(SECONDS, "b", "edits", 4.0),
    ]
    append(rows[:4], tmp_path / "rows.csv")
    append(rows[4:], tmp_path / "rows.csv")
    assert load_rows(tmp_path / "rows.csv") == rows
    text, met = table(rows)
    assert "| pastes | pasted part flagged | 39 of 40 (97.50 %)" in text
    assert (
        "| roc | ROC area of the network | 0.50000 | 2 touched, 1 untouched | at least 1.00000, the rule's |"
        in text
    )
    assert "| edits | 2 | 4 | 4 | 7 |" in text
    assert "| all | 2 | | | 7 |" in text
    assert not met


def test_every_figure_is_measured_by_a_name_of_the_command_line():
    assert {bar.measured_by for bar in FIGURES.values()} == set(program.BARS)


def test_the_program_prints_one_table_and_exits_1_where_a_bar_is_missed(
    subject, monkeypatch, capsys, tmp_path
):
    monkeypatch.setattr(program, "subjects", lambda *_: iter([subject]))
    value = [1.0]
    bar = {"pastes": lambda _, draws: iter([Row("pasted part flagged", "pebble", f"{draws}", value[0])])}
    monkeypatch.setitem(program.BARS, "pastes", bar["pastes"])
    monkeypatch.setattr(
        "sys.argv", ["bars", "pastes", "--draws", "pastes=3", "--rows", str(tmp_path / "rows")]
    )
    assert program.main() == 0
    value[0] = 0.0
    assert program.main() == 1
    assert "pasted part flagged | 1 of 2" in capsys.readouterr().out
    assert {row.detail for row in load_rows(tmp_path / "rows")} == {"3", "marking", "pastes"}


def test_a_model_without_room_counts_against_its_bar(subject, monkeypatch, capsys):
    small = Subject("small", subject.mesh)
    small.__dict__["marked"] = replace(subject.marked, authentication=None)
    monkeypatch.setattr(program, "subjects", lambda *_: iter([small]))
    monkeypatch.setattr("sys.argv", ["bars", "benign"])
    assert program.main() == 1
    assert "no room for the marks 1" in capsys.readouterr().out


def test_a_model_that_a_bar_cannot_mark_counts_and_does_not_end_the_run(subject, monkeypatch, capsys):
    def refuse(*_: object) -> None:
        raise mm.CapacityError("too coarse")

    monkeypatch.setattr(program, "subjects", lambda *_: iter([subject]))
    monkeypatch.setitem(program.BARS, "pastes", refuse)
    monkeypatch.setattr("sys.argv", ["bars", "pastes"])
    assert program.main() == 1
    assert "pastes: too coarse" in capsys.readouterr().out


class _Found:
    """What `authenticate` says, as far as these bars ask."""

    content = None

    def __init__(self, verdict: str) -> None:
        self.verdict = verdict


def _once(made: Callable[..., object], *told_by: str) -> Callable[..., object]:
    """Return a function that remembers what it returned for the same values of these options."""
    kept: dict[tuple[object, ...], object] = {}

    def function(*arguments: object, **options: object) -> object:
        name = tuple(options[each] for each in told_by)
        if name not in kept:
            kept[name] = made(*arguments, **options)
        return kept[name]

    return function


def _stands_in(honest: Callable[..., object], change: Callable[..., object]) -> Callable[..., object]:
    return lambda *arguments, **options: change(honest(*arguments, **options))
