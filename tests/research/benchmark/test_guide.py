"""What docs/benchmark.md shows works as it is written there."""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from pathlib import Path

import numpy as np
import pytest

from meshmark.attacks import parse_chain
from meshmark.cli.main import main
from meshmark.coding.keys import Key
from meshmark.io import write_mesh
from meshmark.research.benchmark.figures.csv_files import results_csv
from meshmark.research.benchmark.run.models import SIZE_CLASSES
from meshmark.research.benchmark.run.row import STATUSES, TRIALS
from meshmark.research.benchmark.run.sample_shape import lopsided
from meshmark.research.benchmark.run.suites import SUITES
from meshmark.research.schemes.scheme import Scheme
from meshmark.research.schemes.table import ENTRY_POINTS
from tests.counting import some
from tests.research.benchmark.planted import planted_rows

DOCS = Path(__file__).parents[3] / "docs"
GUIDE = (DOCS / "benchmark.md").read_text(encoding="utf-8")
OWN = (DOCS / "your-scheme.md").read_text(encoding="utf-8")
(ROWS_EXAMPLE,) = re.findall(r"```python\n(.*?)```", GUIDE, re.DOTALL)
(SCHEME_EXAMPLE,) = re.findall(r"```python\n(.*?)```", OWN, re.DOTALL)


@pytest.fixture(scope="module")
def nudge():
    names: dict[str, object] = {}
    exec(compile(SCHEME_EXAMPLE, "nudge.py", "exec"), names)
    return names["Nudge"]()


def test_the_example_of_a_scheme_keeps_its_promises(nudge):
    assert isinstance(nudge, Scheme)
    mesh, key = lopsided(60), Key(bytes(range(32)))
    bits = np.random.default_rng(1).integers(0, 2, nudge.bits).astype(np.uint8)
    for strength, budget in {"subtle": 2e-4, "standard": 8e-4, "strong": 2e-3}.items():
        marked = nudge.embed(mesh, bits, key, strength=strength)
        moved = np.linalg.norm(marked.vertices - mesh.vertices, axis=1)
        rms = np.sqrt(np.mean(moved**2)) / np.linalg.norm(np.ptp(mesh.vertices, axis=0))
        assert 0.9 * budget < rms <= budget
        read = nudge.extract(marked, key, reference=mesh)
        assert read.present
        assert np.array_equal(read.bits, bits)
        other = nudge.extract(marked, Key(bytes(32)), reference=mesh)
        assert not other.present
        assert 0.2 < np.mean(other.bits != bits) < 0.8
    assert not nudge.extract(mesh, key, reference=mesh).present
    turned = parse_chain("similarity:1")(marked, np.random.default_rng(0))
    assert not np.array_equal(nudge.extract(turned, key, reference=mesh).bits, bits), "as the guide says"


def test_the_example_package_registers_the_scheme_of_the_example():
    (text,) = re.findall(r"```toml\n(.*?)```", OWN, re.DOTALL)
    project = tomllib.loads(text)
    assert project["project"]["entry-points"] == {ENTRY_POINTS: {"nudge": "nudge:Nudge"}}
    assert project["tool"]["setuptools"]["py-modules"] == ["nudge"]
    assert "class Nudge" in SCHEME_EXAMPLE


def test_the_example_on_rows_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("bench-out").mkdir()
    Path("bench-out/results.csv").write_text(results_csv(planted_rows(models=6)), encoding="utf-8")
    exec(compile(ROWS_EXAMPLE, "guide", "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert all(re.fullmatch(r"\S+ +[\d.]+% \[[\d.]+%, [\d.]+%\] of 6 models", line) for line in some(lines))
    assert lines


@pytest.mark.parametrize(("page", "count"), [(GUIDE, 4), (OWN, 2)], ids=["benchmark", "your-scheme"])
def test_the_commands_have_suites_and_options_that_exist(page, count, capsys):
    main(["bench", "--help"])
    known = capsys.readouterr().out
    lines = [shlex.split(line) for line in re.findall(r"^\$ (.*)$", page, re.MULTILINE)]
    commands = [line for line in lines if line[0] == "meshmark"]
    assert len(commands) == count
    for _, command, suite, *rest in some(commands):
        assert command == "bench"
        assert suite in SUITES
        assert all(word in known for word in some(rest) if word.startswith("--"))


def test_the_example_is_measured_from_its_file_alone(tmp_path, capsys):
    (tmp_path / "models").mkdir()
    write_mesh(lopsided(36), tmp_path / "models" / "pebble.ply")
    (tmp_path / "nudge.py").write_text(SCHEME_EXAMPLE, encoding="utf-8")
    options = ["--schemes", str(tmp_path / "nudge.py"), "--data", str(tmp_path / "models"), "--workers", "1"]
    assert main(["bench", "smoke", *options, "--out", str(tmp_path / "out"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    lines = {(line["trial"], line["attack"]): line for line in told["summary"]}
    assert not any(line["failed"] for line in some(lines.values()))
    assert lines["marked", "none"]["recovered"] == 1
    for attack in ("similarity:1", "shuffle:1"):
        assert lines["marked", attack]["recovered"] == 0, "as the page says"
    (told_of,) = told["facts"]["schemes"].values()
    assert re.fullmatch(r"Nudge \(docs/your-scheme\.md, file [0-9a-f]{8}\)", told_of)


def test_the_guide_names_every_suite_trial_outcome_and_size_class():
    for name in some([*SUITES, *TRIALS, *STATUSES[1:]]):
        assert f"`{name}`" in GUIDE, name
    assert all(name in GUIDE for _, name in some(SIZE_CLASSES))


def test_the_guide_names_every_file_that_is_written():
    assert all(f"`{name}`" in GUIDE for name in ("report.html", "report.md", "results.csv", "summary.csv"))
