"""What commands write: nothing existing without --force, never an input or a key, and all of it or nothing."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from folders import enter_copy
from json_object import only_object
from refusals import assert_refused, snapshot

import meshmark as mm
from tests.counting import some
from tests.io.gltf_samples import cube
from tests.shapes import pebble

pytestmark = pytest.mark.usefixtures("short_search")


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of files that tests only read.

    A model, a key, the marked model and its certificate, and another model, `both.ply`, with both layers.
    """
    from meshmark.cli.main import main

    folder = tmp_path_factory.mktemp("small")
    mm.write_mesh(mm.Mesh(*pebble(36)), folder / "in.ply")
    mm.Key(bytes(range(32))).save(folder / "my.key")
    mm.write_mesh(mm.Mesh(*pebble(56)), folder / "larger.ply")
    for text in (
        "embed in.ply marked.ply --key my.key --certificate my.cert --layers ownership",
        "embed larger.ply both.ply --key my.key --layers both",
    ):
        line = [str(folder / word) if "." in word else word for word in text.split()]
        assert main(line) == 0
    (folder / "larger.ply").unlink()
    return folder


# Command lines in which each word with a dot is a file of the folder, and the files that they write.
WRITING = {
    "embed": (
        "embed in.ply new.ply --key my.key --layers ownership --certificate new.cert --report new.html",
        ["new.ply", "new.cert", "new.html"],
    ),
    "extract": ("extract marked.ply --key my.key --report new.html", ["new.html"]),
    "unmark": ("unmark marked.ply new.ply --key my.key --certificate my.cert", ["new.ply"]),
    "recover": (
        "recover both.ply new.ply --key my.key --report new.html --picture new.png",
        ["new.ply", "new.html", "new.png"],
    ),
    "compare": ("compare in.ply marked.ply --picture new.png", ["new.png"]),
    "attack": ("attack in.ply new.ply noise --map new.csv", ["new.ply", "new.csv"]),
    "authenticate": (
        "authenticate both.ply --key my.key --map new.ply --report new.html --payload new.off",
        ["new.ply", "new.html", "new.off"],
    ),
    "saliency": ("saliency in.ply --picture new.png", ["new.png"]),
    "segment": ("segment in.ply --picture new.png", ["new.png"]),
}


@pytest.fixture
def place(small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of copies, which is the current one."""
    enter_copy(small, tmp_path, monkeypatch)
    return tmp_path


@pytest.mark.parametrize("command", WRITING)
def test_no_existing_output_is_replaced_without_force(cli, place, command):
    line, outputs = WRITING[command]
    assert cli(*line.split()).code == 0
    made = snapshot(place)
    assert set(outputs) <= made.keys()
    for taken in some(outputs):
        for other in outputs:
            if other != taken:
                (place / other).unlink(missing_ok=True)
        (place / taken).write_bytes(b"of the user")
        before = snapshot(place)
        ran = cli(*line.split())
        assert_refused(ran, place, before)
        assert f"{taken} exists already, expected a new name, or --force to replace it" in ran.err
        assert_refused(cli(*line.split(), "--json"), place, before)
    ran = cli(*line.split(), "--force", "--json")
    assert ran.code == 0
    told = only_object(ran.out)
    assert sorted(told["outputs"].values()) == sorted(outputs)
    assert snapshot(place).keys() == made.keys()
    assert all((place / name).read_bytes() != b"of the user" for name in some(outputs))


@pytest.mark.parametrize("link", [os.link, os.symlink])
@pytest.mark.parametrize("command", WRITING)
def test_an_input_is_never_an_output_through_links_either(cli, place, command, link):
    line, outputs = WRITING[command]
    source = line.split()[1]
    for name in some(outputs):
        for kept in (source, "my.key"):
            link(place / kept, place / name)
            before = snapshot(place)
            ran = cli(*line.split(), "--force")
            assert_refused(ran, place, before)
            assert "never overwritten" in ran.err
            (place / name).unlink()


def test_a_file_that_an_input_refers_to_is_never_an_output(cli, place):
    (place / "scene.gltf").write_bytes(cube().external(place))
    (place / "painted.obj").write_text("mtllib painted.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (place / "painted.mtl").write_text("newmtl red\n")
    (place / "buffer.csv").unlink(missing_ok=True)
    (buffer,) = place.glob("*.bin")
    buffer.rename(place / "buffer.csv")
    text = (place / "scene.gltf").read_bytes()
    (place / "scene.gltf").write_bytes(text.replace(b"old%20buffer.bin", b"buffer.csv"))
    before = snapshot(place)
    for line in (
        "attack scene.gltf new.gltf noise --map buffer.csv --force",
        "attack painted.obj painted.mtl noise --force",
        "authenticate both.ply --key my.key --original scene.gltf --payload buffer.csv --force",
    ):
        assert_refused(cli(*line.split()), place, before)


def test_two_outputs_of_one_name_are_refused(cli, place):
    (place / "same.ply").symlink_to(place / "new.ply")
    before = snapshot(place)
    for line in (
        "embed in.ply new.ply --key my.key --certificate new.ply",
        "embed in.ply new.ply --key my.key --certificate same.ply",
        "authenticate both.ply --key my.key --map new.ply --payload new.ply",
        "authenticate both.ply --key my.key --map new.ply --payload same.ply",
    ):
        ran = cli(*line.split(), "--force")
        assert_refused(ran, place, before)
        assert "two results are to go to" in ran.err


def test_standard_output_is_no_place_for_a_model(cli, place):
    before = snapshot(place)
    ran = cli("attack", "in.ply", "-", "noise")
    assert_refused(ran, place, before)
    assert "nothing is written to standard output but answers" in ran.err


LIMITED = """
import resource, sys
limit = int(sys.argv.pop(1))
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
from meshmark.cli.main import run
run()
"""


def limited(limit: int, line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a command line that can make no file longer than `limit` bytes."""
    return subprocess.run(
        [sys.executable, "-c", LIMITED, str(limit), *line.split()],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        cwd=folder,
    )


def test_a_certificate_that_does_not_fit_takes_the_marked_model_with_it(cli, place):
    """As on a full disk: the model is written and read back, then its certificate is too long."""
    line = "embed in.ply new.ply --key my.key --layers ownership --certificate new.cert"
    sizes = (place / "marked.ply").stat().st_size, (place / "my.cert").stat().st_size
    assert sizes[0] + 1000 < sizes[1], "only the certificate is over the limit"
    before = snapshot(place)
    ran = limited(sizes[0] + 1000, line, place)
    assert ran.returncode == 2, ran.stderr
    assert ran.stderr == "meshmark: cannot write new.cert: File too large\n"
    assert ran.stdout == ""
    assert snapshot(place) == before


def test_with_force_what_was_there_stays_where_the_disk_is_full(place):
    (place / "new.ply").write_bytes(b"older model")
    (place / "new.cert").write_bytes(b"older certificate")
    before = snapshot(place)
    line = "embed in.ply new.ply --key my.key --layers ownership --certificate new.cert --force --json"
    ran = limited((place / "marked.ply").stat().st_size + 1000, line, place)
    assert ran.returncode == 2
    error = only_object(ran.stdout)["error"]
    assert error == {"kind": "output", "message": "cannot write new.cert: File too large", "file": "new.cert"}
    assert snapshot(place) == before


def test_no_output_takes_its_name_where_one_does_not_fit(cli, place):
    line, outputs = WRITING["attack"]
    assert cli(*line.split()).code == 0
    sizes = [(place / name).stat().st_size for name in outputs]
    for name in outputs:
        (place / name).unlink()
    before = snapshot(place)
    ran = limited(max(sizes) - 1, line, place)
    assert ran.returncode == 2, ran
    assert ran.stderr.endswith("File too large\n")
    assert snapshot(place) == before


def failing(at: int) -> Callable[[object, object], None]:
    """Return `os.link` that fails at its `at`-th call, as where the last of a disk's space is gone."""
    calls: list[object] = []
    real = os.link

    def link(source: object, target: object, **options: bool) -> None:
        calls.append(target)
        if len(calls) == at:
            raise FileExistsError(17, "File exists")
        real(source, target, **options)  # type: ignore[arg-type]

    return link


@pytest.mark.parametrize(("command", "at"), [("attack", 1), ("embed", 2)])
def test_a_move_that_fails_is_taken_back(cli, place, monkeypatch, command, at):
    before = snapshot(place)
    monkeypatch.setattr(os, "link", failing(at))
    line, _ = WRITING[command]
    assert_refused(cli(*line.split()), place, before)


def test_a_benchmark_spares_a_folder_that_is_not_its_own(cli, place):
    (place / "out").mkdir()
    (place / "out" / "report.md").write_text("mine")
    before = snapshot(place)
    ran = cli("bench", "smoke", "--data", "nowhere", "--out", "out")
    assert_refused(ran, place, before)
    assert "out/report.md exists already and no run of a benchmark made it" in ran.err
    ran = cli("bench", "smoke", "--data", "nowhere", "--out", "out", "--force")
    assert "nowhere is not a folder" in ran.err


def test_training_spares_an_existing_network(cli, place):
    (place / "net.json").write_text("mine")
    before = snapshot(place)
    ran = cli("train", "--data", "nowhere", "--out", "net.json")
    assert_refused(ran, place, before)
    assert "net.json exists already" in ran.err


def test_the_limit_of_these_tests_holds_for_their_children_only():
    assert (
        resource.getrlimit(resource.RLIMIT_FSIZE)[0] > 1_000_000
        or resource.getrlimit(resource.RLIMIT_FSIZE)[0] < 0
    )
