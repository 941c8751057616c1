"""`authenticate`, `recover` and `unmark`: fields, exit codes and files, on one model that is edited."""

from __future__ import annotations

import hashlib
import re
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from json_object import only_object
from numpy.typing import NDArray
from PIL import Image

import meshmark as mm
from meshmark.coding.elapsed import SECONDS
from meshmark.coding.keys import LOG10_GUESS
from tests.counting import some

pytestmark = pytest.mark.usefixtures("short_search")

FIELDS = {
    "verdict", "altered_vertices", "altered_area_fraction", "regions", "payload", "log10_false_positive", "seconds",
}  # fmt: skip
REGION = {"id", "verdict", "probability", "checks", "failed", "centre"}


class Edited(NamedTuple):
    """A marked model of which a ball of vertices was pushed."""

    path: Path
    pushed: NDArray[np.bool_]


@pytest.fixture(scope="module")
def edited(files, tmp_path_factory):
    mesh = mm.read_mesh(files.marked)
    diagonal = np.linalg.norm(np.ptp(mesh.vertices, axis=0))
    near = np.linalg.norm(mesh.vertices - mesh.vertices[mesh.vertices[:, 1].argmax()], axis=1)
    weight = np.clip(1.0 - (near / (0.15 * diagonal)) ** 2, 0.0, 1.0)
    place = tmp_path_factory.mktemp("edited") / "edited.ply"
    mm.write_mesh(mesh.with_vertices(mesh.vertices + 0.03 * diagonal * weight[:, None]), place)
    return Edited(place, weight > 0.0)


@pytest.fixture(scope="module")
def sealed(files, tmp_path_factory):
    """Return the model with the upper layer alone, an image as its payload, and its certificate."""
    import contextlib
    import io

    from meshmark.cli.main import main

    folder = tmp_path_factory.mktemp("sealed")
    Image.fromarray(np.arange(300, dtype=np.uint8).reshape(10, 30)).save(folder / "logo.png")
    with contextlib.redirect_stdout(io.StringIO()):
        code = main(
            [str(word) for word in (
                "embed", files.model, folder / "sealed.ply", "--key", files.key, "--layers", "authentication",
                "--payload", folder / "logo.png", "--certificate", folder / "sealed.cert",
            )]
        )  # fmt: skip
    assert code == 0
    return folder


def read_map(path: Path) -> tuple[NDArray[np.float64], NDArray[np.uint8], NDArray[np.uint8]]:
    """Return positions, colours and the property `altered` of a map, by a reading of its own."""
    header, _, body = path.read_bytes().partition(b"end_header\n")
    lines = header.decode("ascii").splitlines()
    count = int(next(line.split()[2] for line in lines if line.startswith("element vertex")))
    kinds = {"float": "<f4", "double": "<f8", "uchar": "u1"}
    properties = [line.split()[1:] for line in lines if line.startswith("property") and "list" not in line]
    rows = np.frombuffer(body, [(name, kinds[kind]) for kind, name in properties], count)
    positions = np.stack([rows[name].astype(float) for name in "xyz"], axis=1)
    return positions, np.stack([rows[name] for name in ("red", "green", "blue")], axis=1), rows["altered"]


def test_an_untouched_model_is_authentic(cli, files, tmp_path):
    ran = cli("authenticate", files.marked, "--key", files.key, "--map", tmp_path / "map.ply", "--json")
    found = only_object(ran.out)
    assert (ran.code, ran.err) == (0, "")
    assert found.keys() >= FIELDS
    assert (found["verdict"], found["altered_vertices"], found["payload"]) == ("authentic", 0, "recovered")
    assert found["log10_false_positive"] == -30.0
    told = only_object(cli("authenticate", files.marked, "--key", files.key, "--diagnose", "--json").out)
    assert told["log10_false_positive"] == LOG10_GUESS, "no bound is below that of guessing the key"
    assert told["seconds"] not in SECONDS
    assert found["seconds"] in SECONDS
    assert found["regions"]
    assert all(region.keys() >= REGION for region in some(found["regions"]))
    assert {region["verdict"] for region in found["regions"]} == {"intact"}
    positions, _, altered = read_map(tmp_path / "map.ply")
    assert np.array_equal(positions, mm.read_mesh(files.marked).vertices)
    assert not altered.any()


def test_an_edited_model_is_altered_and_the_map_shows_where(cli, files, edited, tmp_path):
    ran = cli(
        "authenticate", edited.path, "--key", files.key, "--map", tmp_path / "map.ply",
        "--report", tmp_path / "page.html", "--payload", tmp_path / "small.ply",
    )  # fmt: skip
    assert (ran.code, ran.err) == (1, "")
    assert re.match(
        r"Altered: .*: top.*, [\d.]+ % of the surface\. Chance .* below 10\^-30\.$",
        ran.out.strip(),
    )
    positions, colours, altered = read_map(tmp_path / "map.ply")
    assert np.array_equal(positions, mm.read_mesh(edited.path).vertices)
    both, either = (altered == 1) & edited.pushed, (altered == 1) | edited.pushed
    assert both.sum() / either.sum() > 0.85
    assert both.sum() / edited.pushed.sum() > 0.95
    assert len(np.unique(colours[altered == 1], axis=0)) == len(np.unique(colours[altered == 0], axis=0)) == 1
    assert set(np.unique(altered)) == {0, 1}
    small = mm.read_mesh(tmp_path / "small.ply")
    assert 50 < len(small.faces) < 20_000


def test_the_page_is_complete_in_itself_and_names_every_region(cli, files, edited, tmp_path):
    name = tmp_path / "<b>.ply"
    name.write_bytes(edited.path.read_bytes())
    ran = cli("authenticate", name, "--key", files.key, "--report", tmp_path / "page.html", "--json")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    found = only_object(ran.out)
    assert "<h1>Altered</h1>" in page
    assert "shows such marks is below 10<sup>−30</sup>" in page
    assert "<b>.ply" not in page
    assert hashlib.sha256(name.read_bytes()).hexdigest() in page
    assert found["key"] in page
    page = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)  # the viewer, if it is installed
    assert not re.search(r"""(src|href)=["'](?!data:)""", page)
    assert not re.search(r"url\(|@import", page)
    assert page.count("data:image/png;base64,") == 4
    rows = re.findall(r'<th scope="row">(\d+)</th>', page)
    assert sorted(map(int, rows)) == [region["id"] for region in found["regions"]]
    called = [region["id"] for region in found["regions"] if region["verdict"] == "altered"]
    assert sorted(map(int, rows[: len(called)])) == sorted(called)


def test_another_key_finds_nothing(cli, files, tmp_path):
    mm.Key(b"another key of thirty-two bytes!").save(tmp_path / "b.key")
    ran = cli("authenticate", files.marked, "--key", tmp_path / "b.key", "--json")
    found = only_object(ran.out)
    assert (ran.code, found["verdict"], found["altered_vertices"]) == (1, "not_marked", 0)
    ran = cli("recover", files.marked, tmp_path / "out.ply", "--key", tmp_path / "b.key")
    assert ran.code == 1
    assert ran.out.startswith("Not recovered")
    assert not (tmp_path / "out.ply").exists()


def test_the_id_alone_does_not_tell_and_its_certificate_does(cli, files, small_model, tmp_path):
    out, certificate = tmp_path / "id.ply", tmp_path / "id.cert"
    arguments = ("--key", files.key, "--layers", "ownership", "--certificate", certificate)
    assert cli("embed", small_model, out, *arguments).code == 0
    ran = cli("authenticate", out, "--key", files.key)
    assert ran.code == 3
    assert ran.out.startswith("Inconclusive")
    assert "whether it was changed cannot be told" in ran.out
    ran = cli("authenticate", out, "--key", files.key, "--certificate", certificate)
    assert (ran.code, ran.out[:9]) == (0, "Authentic")


def test_what_cannot_be_told_exits_with_3(cli, files, monkeypatch):
    import meshmark.marking as scheme

    sure = scheme.authenticate(mm.read_mesh(files.marked), mm.Key.load(files.key))
    unsure = replace(sure, verdict="inconclusive", advice="The model is too small.")
    monkeypatch.setattr(scheme, "authenticate", lambda *_, **__: unsure)
    ran = cli("authenticate", files.marked, "--key", files.key)
    assert ran.code == 3
    assert ran.out.startswith("Inconclusive")
    assert "too small" in ran.out


def test_recover_brings_the_part_back_and_leaves_the_rest(cli, files, edited, tmp_path):
    ran = cli("recover", edited.path, tmp_path / "whole.ply", "--key", files.key, "--json")
    found = only_object(ran.out)
    assert ran.code == 0, ran
    assert found.keys() >= {"altered_area_fraction", "vertices_moved", "faces_added", "seconds"}
    marked, suspect, whole = (
        mm.read_mesh(path).vertices for path in (files.marked, edited.path, tmp_path / "whole.ply")
    )
    before, after = (np.linalg.norm((one - marked)[edited.pushed], axis=1) for one in (suspect, whole))
    assert np.sqrt((after**2).mean()) < 0.8 * np.sqrt((before**2).mean())
    moved = (whole != suspect).any(axis=1)
    assert found["vertices_moved"] == moved.sum()
    assert not (moved & (np.linalg.norm(suspect - marked, axis=1) == 0)).sum() > 0.1 * moved.sum()


def test_recover_with_the_original_gives_the_marked_file_back(cli, files, edited, tmp_path):
    ran = cli(
        "recover",
        edited.path,
        tmp_path / "whole.ply",
        "--key",
        files.key,
        "--original",
        files.model,
        "--json",
    )
    found = only_object(ran.out)
    assert ran.code == 0, ran
    assert found["restored_from"] == "marked_copy"
    assert (tmp_path / "whole.ply").read_bytes() == files.marked.read_bytes()


def test_recover_of_an_untouched_model_is_a_copy(cli, files, tmp_path):
    assert cli("recover", files.marked, tmp_path / "same.ply", "--key", files.key).code == 0
    assert (tmp_path / "same.ply").read_bytes() == files.marked.read_bytes()


def test_an_image_comes_back_byte_for_byte(cli, files, sealed, tmp_path):
    ran = cli(
        "authenticate", sealed / "sealed.ply", "--key", files.key, "--payload", tmp_path / "logo", "--json"
    )
    found = only_object(ran.out)
    assert (ran.code, found["verdict"], found["payload_kind"]) == (0, "authentic", "image")
    assert (tmp_path / "logo").read_bytes() == (sealed / "logo.png").read_bytes()
    ran = cli("recover", sealed / "sealed.ply", tmp_path / "out.ply", "--key", files.key)
    assert ran.code == 0
    assert "Nothing was altered" in ran.out


def test_extract_answers_with_the_id_of_marks_of_authentication_alone(cli, files, sealed, tmp_path):
    line = ("extract", sealed / "sealed.ply", "--key", files.key)
    ran, told = cli(*line), cli(*line, "--json")
    identity = only_object(cli("authenticate", *line[1:], "--json").out)["id"]
    assert (ran.code, told.code) == (0, 0)
    assert ran.out.startswith(f"Present: {line[1]} carries the id {identity}; ")
    found = only_object(told.out)
    assert (found["presence"], found["id"]) == ("present", identity)
    assert found["advice"].startswith(
        "The id was read from the authentication marks; the ownership mark was not found."
    )
    assert [(entry["layer"], entry["id"]) for entry in found["evidence"]] == [("authentication", identity)]
    assert found["evidence"][0]["log10_false_positive"] <= found["log10_false_positive"] <= -6
    mm.Key(b"another key of thirty-two bytes!").save(tmp_path / "b.key")
    other = cli(*line[:2], "--key", tmp_path / "b.key", "--json")
    assert (other.code, only_object(other.out)["evidence"]) == (1, [])


def test_a_payload_that_is_not_there_is_not_passed_over(cli, files, tmp_path):
    mark = ("--layers", "authentication", "--payload", "none")
    assert cli("embed", files.model, tmp_path / "bare.ply", "--key", files.key, *mark).code == 0
    ran = cli("authenticate", tmp_path / "bare.ply", "--key", files.key, "--payload", tmp_path / "out")
    assert ran.code == 1
    assert ran.out.startswith("Authentic")
    assert "no payload was recovered" in ran.err
    assert not (tmp_path / "out").exists()


def test_an_error_names_the_file(cli, files, tmp_path):
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nf 1 2 2\n")
    ran = cli("authenticate", tmp_path / "flat.obj", "--key", files.key)
    assert (ran.code, len(ran.err.splitlines())) == (2, 1)
    assert "flat.obj" in ran.err


def test_unmark_returns_the_original(cli, files, sealed, tmp_path):
    arguments = ("--key", files.key, "--certificate", sealed / "sealed.cert")
    ran = cli("unmark", sealed / "sealed.ply", tmp_path / "plain.ply", *arguments, "--json")
    assert (ran.code, only_object(ran.out)["exact"]) == (0, True)
    before, after = mm.read_mesh(files.model).vertices, mm.read_mesh(tmp_path / "plain.ply").vertices
    diagonal = np.linalg.norm(np.ptp(before, axis=0))
    assert np.linalg.norm(after - before, axis=1).max() <= 1e-6 * diagonal
    assert cli("authenticate", tmp_path / "plain.ply", "--key", files.key).code == 1


def test_what_was_never_marked_is_not_unmarked(cli, files, sealed, tmp_path):
    arguments = ("--key", files.key, "--certificate", sealed / "sealed.cert")
    ran = cli("unmark", files.model, tmp_path / "plain.ply", *arguments)
    assert (ran.code, len(ran.err.splitlines())) == (2, 1)
    assert "no mark of this key" in ran.err
    assert not (tmp_path / "plain.ply").exists()


def test_a_payload_that_does_not_fit_is_refused_with_what_does(cli, files, tmp_path):
    (tmp_path / "long").write_bytes(bytes(100_000))
    arguments = ("--layers", "authentication", "--payload", tmp_path / "long")
    ran = cli("embed", files.model, tmp_path / "out.ply", "--key", files.key, *arguments)
    assert ran.code == 4
    assert re.search(r"100,000 bytes, expected at most [\d,]+", ran.err)
    assert len(ran.err.splitlines()) == 1
    assert not (tmp_path / "out.ply").exists()
