"""`meshmark batch`: many models, each in a process of its own, resumable, the same copies in every run."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

import meshmark as mm
from meshmark.cli.batch import BATCH_COMMANDS
from tests.keys import KEY
from tests.shapes import pebble

QUICK = ("--layers", "ownership", "--key", "my.key")


@pytest.fixture(scope="module")
def source(tmp_path_factory) -> Path:
    """A folder with models/, three models and one that is none, and a key."""
    folder = tmp_path_factory.mktemp("batch")
    (folder / "models" / "sub").mkdir(parents=True)
    for number, name in enumerate(("a.ply", "b.obj", "sub/c.off")):
        mm.write_mesh(mm.Mesh(*pebble(32 + 2 * number)), folder / "models" / name)
    (folder / "models" / "broken.ply").write_text("ply\nnothing\n")
    KEY.save(folder / "my.key")
    return folder


def started(source: Path, *line: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "meshmark", "batch", *line],
        cwd=source, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


def ended(source: Path, *line: str) -> tuple[int, str, str]:
    process = started(source, *line)
    out, err = process.communicate(timeout=300)
    return process.returncode, out, err


def rows(out: Path) -> dict[str, dict[str, object]]:
    found = [json.loads(line) for line in (out / "results.jsonl").read_text().splitlines()]
    assert len({row["model"] for row in found}) == len(found), "every model once"
    return {row["model"]: row for row in found}


def copies(out: Path) -> dict[str, bytes]:
    models = [path for path in out.rglob("*") if path.suffix in (".ply", ".obj", ".off")]
    return {path.relative_to(out).as_posix(): path.read_bytes() for path in models}


@pytest.fixture(scope="module")
def undisturbed(source) -> Path:
    code, out, _ = ended(source, "embed", "models", "whole", *QUICK, "--workers", "1")
    assert (code, out) == (1, "4 models: 1 failed: format, 3 marked. Results: whole/results.jsonl\n")
    return source / "whole"


def test_each_model_has_a_row_as_the_single_command_says_it(cli, source, undisturbed, monkeypatch):
    found = rows(undisturbed)
    assert found.keys() == {"a.ply", "b.obj", "broken.ply", "sub/c.off"}
    assert found["broken.ply"]["error"]["kind"] == "format"
    assert copies(undisturbed).keys() == found.keys() - {"broken.ply"}
    monkeypatch.chdir(source)
    row = found["sub/c.off"]
    told = json.loads(cli("extract", "whole/sub/c.off", "--key", "my.key", "--json").out)
    assert (told["presence"], told["id"]) == ("present", row["id"])
    alone = cli("embed", "models/sub/c.off", "alone.off", *QUICK, "--id", row["id"], "--json")
    single = json.loads(alone.out)
    assert single.keys() == row.keys() - {"model", "digest", "exit_code"}
    changing = {"seconds", "outputs"}
    assert {name: row[name] for name in single.keys() - changing} == {
        name: value for name, value in single.items() if name not in changing
    }
    assert (source / "alone.off").read_bytes() == copies(undisturbed)["sub/c.off"]


def test_a_killed_run_goes_on_and_makes_the_same_copies(source, undisturbed):
    process = started(source, "embed", "models", "killed", *QUICK, "--workers", "1")
    results = source / "killed" / "results.jsonl"
    while process.poll() is None and not (results.exists() and results.stat().st_size):
        time.sleep(0.02)
    assert process.poll() is None, "it was killed while it worked"
    process.kill()
    process.communicate()
    code, out, err = ended(source, "embed", "models", "killed", *QUICK, "--workers", "1", "--resume")
    assert (code, err.count("\n")) == (1, 1)
    assert out.startswith("4 models: 1 failed: format, 3 marked.")
    assert copies(source / "killed") == copies(undisturbed)
    assert rows(source / "killed").keys() == rows(undisturbed).keys()
    assert not list((source / "killed").rglob(".meshmark.*"))


def test_a_copy_that_was_issued_before_its_row_was_written_is_not_issued_again(cli, source, monkeypatch):
    pytest.importorskip("sqlalchemy")
    monkeypatch.chdir(source)
    (source / "people.csv").write_text("path,recipient\nmodels/a.ply,Ada\n")
    assert cli("registry", "init", "--registry", "r.sqlite").code == 0
    line = ("batch", "embed", "people.csv", "issued", *QUICK, "--registry", "r.sqlite", "--workers", "1")
    assert cli(*line).code == 0
    (first,) = rows(source / "issued").values()
    assert first["recipient"] == "Ada"
    records = json.loads(cli("registry", "list", "--registry", "r.sqlite", "--json").out)["records"]
    copy = copies(source / "issued")
    (source / "issued" / "results.jsonl").write_bytes(b"")
    assert cli(*line, "--resume").code == 0
    (again,) = rows(source / "issued").values()
    assert again["id"] == first["id"] == records[0]["id"]
    assert again["recipient"] == "Ada"
    assert copies(source / "issued") == copy
    assert json.loads(cli("registry", "list", "--registry", "r.sqlite", "--json").out)["records"] == records
    ran = cli(
        "batch", "trace", "issued", "traced", "--key", "my.key", "--registry", "r.sqlite", "--workers", "1"
    )
    (traced,) = rows(source / "traced").values()
    assert (ran.code, traced["matches"][0]["recipient"]) == (0, "Ada")
    assert ran.out == "1 model: 1 traced. Results: traced/results.jsonl\n"


def test_copies_are_read_and_rows_are_printed_as_they_come(cli, source, undisturbed, monkeypatch):
    monkeypatch.chdir(source)
    ran = cli("batch", "extract", "whole/**/*", "read", "--key", "my.key", "--workers", "1", "--json-lines")
    told = {row["model"]: row for row in map(json.loads, ran.out.splitlines())}
    assert ran.code == 0
    assert told == rows(source / "read")
    assert told.keys() == copies(undisturbed).keys()
    marked = rows(undisturbed)
    assert {name: row["id"] for name, row in told.items()} == {name: marked[name]["id"] for name in told}
    summary = json.loads((source / "read" / "summary.json").read_text())
    assert (summary["models"], summary["outcomes"]) == (3, {"present": 3})


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("embed models whole", "whole/results.jsonl is there from an earlier run, expected --resume"),
        ("embed models other --workers 1 --scheduler tcp://nowhere:1", "exclude each other"),
        ("embed models models", "is also an input, which is never overwritten"),
        ("embed nothing other", "nothing is not there"),
        ("embed twice.txt other", "names models/a.ply twice"),
        ("embed empty other", "there is no model in empty"),
        ("embed models taken", "taken/a.ply exists already"),
        ("extract models/a.ply whole --resume", "which is not in models/a.ply"),
        ("trace models other", "no registry is named"),
    ],
)
def test_what_cannot_be_is_refused_before_any_work(cli, source, undisturbed, monkeypatch, line, says):
    monkeypatch.chdir(source)
    monkeypatch.delenv("MESHMARK_REGISTRY", raising=False)
    (source / "twice.txt").write_text("models/a.ply\nmodels/a.ply\n")
    for folder in ("empty", "taken"):
        (source / folder).mkdir(exist_ok=True)
    (source / "taken" / "a.ply").write_text("mine")
    before = copies(source)
    ran = cli("batch", *line.split(), "--key", "my.key")
    assert ran.code == 2
    assert says in ran.err
    assert copies(source) == before


def test_every_command_says_what_it_does():
    assert list(BATCH_COMMANDS) == ["embed", "extract", "authenticate", "trace"]
    assert [name for name, command in BATCH_COMMANDS.items() if not command.__doc__] == []
