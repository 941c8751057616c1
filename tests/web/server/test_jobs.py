"""Jobs through the API of a running server: what comes of them is what the command line makes."""

from __future__ import annotations

import json
import time
import zipfile

import numpy as np
import pytest

from meshmark.cli.main import main
from meshmark.coding.keys import Key
from meshmark.io import read_mesh, write_mesh
from meshmark.marking import extract
from meshmark.mesh import Mesh
from tests.counting import some
from tests.low_poly import box
from tests.shapes import pebble
from tests.web.server.served import wait_for


def printed(capsys, *arguments: object) -> dict:
    """Return what the command line prints with --json."""
    capsys.readouterr()
    main([str(argument) for argument in (*arguments, "--json")])
    return json.loads(capsys.readouterr().out)


def test_the_result_of_an_embedding_is_the_json_of_the_command_line(
    server, marked_job, pebble_file, tmp_path, capsys
):
    mine = printed(
        capsys, "embed", pebble_file, tmp_path / "pebble_marked.ply", "--key", server.key,
        "--id", marked_job["result"]["id"], "--certificate", tmp_path / "c.cert",
    )  # fmt: skip
    theirs = marked_job["result"]
    assert theirs.keys() == mine.keys()
    assert theirs["input"] == "pebble.ply"
    assert theirs["outputs"]["model"] == "pebble_marked.ply"
    apart = {"seconds", "input", "outputs"}
    assert {name: theirs[name] for name in theirs.keys() - apart} == {
        name: mine[name] for name in mine.keys() - apart
    }
    with server.client() as client:
        assert client.get(f"/api/jobs/{marked_job['id']}/result").json() == theirs
        download = next(each for each in marked_job["downloads"] if each["kind"] == "model")
        assert client.get(download["url"]).content == (tmp_path / "pebble_marked.ply").read_bytes()


def test_the_id_is_read_as_the_command_line_reads_it(server, marked_job, marked_file, capsys):
    found = server.run("extract", marked_file)
    assert (found["exit_code"], found["result"]["id"]) == (0, marked_job["result"]["id"])
    assert found["words"].startswith("Present: pebble_marked.ply carries the id")
    mine = printed(capsys, "extract", marked_file, "--key", server.key)
    apart = {"input": "", "outputs": {}, "seconds": 0}
    assert {**found["result"], **apart} == {**mine, **apart}


def test_a_small_model_carries_an_id_of_32_bits_or_none_where_that_is_asked_for(server, tmp_path):
    write_mesh(Mesh(*box((2, 2, 2), (3.0, 2.0, 1.3))), tmp_path / "small.ply")
    short = server.run("embed", tmp_path / "small.ply", bits="32", id="0000beef")
    assert (short["result"]["id"], short["result"]["bits"]) == ("0000beef", 32)
    none = server.run("embed", tmp_path / "small.ply", bits="0")
    assert (none["exit_code"], none["result"]["id"], none["result"]["bits"]) == (0, None, 0)
    with server.client() as client:
        answer = server.begin(
            "embed", tmp_path / "small.ply", client=client, bits="32", id="00000000deadbeef"
        )
    assert answer.status_code == 422
    assert "is one of 64 bits, expected 8 hexadecimal digits" in answer.text


def test_the_certificate_takes_the_mark_off(server, marked_job, marked_file, pebble_file, tmp_path):
    certificate = server.save(marked_job, "certificate", tmp_path)
    job = server.run("unmark", marked_file, certificate=certificate)
    assert job["result"]["exact"]
    back = read_mesh(server.save(job, "model", tmp_path)).vertices
    assert np.abs(back - read_mesh(pebble_file).vertices).max() < 1e-5


def test_what_is_no_model_fails_with_the_sentence_of_the_command_line(server, tmp_path):
    (tmp_path / "notes.txt").write_bytes(b"no model at all")
    job = server.run("embed", tmp_path / "notes.txt")
    assert (job["state"], job["exit_code"], job["result"]) == ("failed", 2, None)
    assert job["error"]["message"].startswith(
        "notes.txt is not a model file in a known format, expected one of"
    )
    assert (job["error"]["kind"], job["error"]["file"]) == ("input", "notes.txt")
    with server.client() as client:
        answer = client.get(f"/api/jobs/{job['id']}/result")
        assert (answer.status_code, answer.json()["error"]) == (422, job["error"])


def test_a_gltf_comes_with_its_files_and_goes_back_with_them(server, tmp_path):
    """Its texture lies in a folder, which an upload does not tell."""
    points, faces = pebble(36)
    write_mesh(Mesh(points, faces), tmp_path / "plain.gltf")
    tree = json.loads((tmp_path / "plain.gltf").read_text())
    buffers = [tmp_path / each["uri"] for each in tree["buffers"] if not each["uri"].startswith("data:")]
    tree["images"] = [{"uri": "textures/skin.png"}]
    (tmp_path / "model.gltf").write_text(json.dumps(tree))
    skin = tmp_path / "skin.png"
    skin.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
    job = server.run(
        "embed", tmp_path / "model.gltf", *buffers, skin, layers="ownership", id="0000000000000005"
    )
    assert job["state"] == "done", job["error"]
    assert "textures/skin.png" in job["result"]["side_files"]
    assert str(server.temporary) not in json.dumps(job)
    saved = server.save(job, "model", tmp_path)
    assert saved.name == "model_marked.zip"
    with zipfile.ZipFile(saved) as archive:
        assert {"model_marked.gltf", "textures/skin.png"} <= set(archive.namelist())
        archive.extractall(tmp_path / "unpacked")
    assert (tmp_path / "unpacked/textures/skin.png").read_bytes() == skin.read_bytes()
    marked = read_mesh(tmp_path / "unpacked/model_marked.gltf")
    assert extract(marked, Key.load(server.key)).id == int(job["result"]["id"], 16)


def test_two_jobs_at_once_do_not_mix(server, tmp_path):
    write_mesh(Mesh(*pebble(30)), tmp_path / "one.ply")
    write_mesh(Mesh(*pebble(32)), tmp_path / "other.stl")
    with server.client() as client:
        begun = [
            server.begin("embed", tmp_path / name, client=client, id=identity, layers="ownership")
            for name, identity in (("one.ply", "00000000000000aa"), ("other.stl", "00000000000000bb"))
        ]
        first, second = (wait_for(each.json()["id"], client) for each in begun)
    assert (first["result"]["id"], second["result"]["id"]) == ("00000000000000aa", "00000000000000bb")
    assert first["result"]["vertices"] == len(pebble(30)[0])
    assert second["downloads"][0]["name"] == "other_marked.stl"


def test_a_cancelled_job_is_gone_with_its_files_and_its_process(server, pebble_file):
    with server.client() as client:
        job = server.begin("embed", pebble_file, client=client).json()
        assert list(server.temporary.glob(f"*/{job['id']}"))
        assert client.delete(f"/api/jobs/{job['id']}").status_code == 204
        deadline = time.monotonic() + 10
        while list(server.temporary.glob(f"*/{job['id']}")) and time.monotonic() < deadline:
            time.sleep(0.02)
        assert list(server.temporary.glob(f"*/{job['id']}")) == []
        gone = client.get(f"/api/jobs/{job['id']}")
    assert (gone.status_code, gone.json()["error"]["kind"]) == (404, "not_found")


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        ({"action": "trace"}, "trace needs a registry"),
        ({"action": "unmark"}, "unmark needs the certificate"),
        (
            {"action": "recover", "strength": "strong"},
            "recover does not take 'strength', expected no options",
        ),
        ({"action": "embed", "recipient": "Ann"}, "a recipient is kept in a registry"),
        ({"action": "embed", "id": "--force"}, "id"),
        ({"action": "embed", "key": "nobody"}, "there is no key 'nobody'"),
        ({"action": "embed", "key": "../studio"}, "key: "),
        ({"action": "extract", "time_limit": "nan"}, "time_limit"),
        ({"action": "melt"}, "action: "),
    ],
)
def test_what_cannot_be_done_is_refused_at_once(server, pebble_file, fields, sentence):
    with server.client() as client:
        data = {"key": "studio", **fields}
        answer = client.post("/api/jobs", data=data, files={"files": ("a.ply", pebble_file.read_bytes())})
    assert answer.status_code == 422
    assert sentence in answer.json()["error"]["message"]


def test_a_file_is_only_found_by_the_name_that_the_job_gave_it(server, marked_job):
    with server.client() as client:
        for name in ("..%2F..%2Flock", "%2Fetc%2Fpasswd", "pebble.ply", "in%2Fpebble.ply"):
            answer = client.get(f"/api/jobs/{marked_job['id']}/files/{name}")
            assert answer.status_code == 404


def test_nothing_that_the_server_says_holds_the_secret_of_a_key(server, marked_job):
    secret = server.key.read_text().splitlines()[1]
    with server.client() as client:
        pages = [client.get(path).text for path in ("/api/keys", "/api/server", "/api/openapi.json", "/")]
        pages.append(client.get(f"/api/jobs/{marked_job['id']}").text)
    for page in some([*pages, server.log.read_text()], least=6):
        assert secret not in page
        assert str(server.keys) not in page.replace(f"with the keys in {server.keys}", "")


def test_with_a_registry_copies_are_entered_listed_and_traced(registry_server, tmp_path):
    server = registry_server
    write_mesh(Mesh(*pebble(30)), tmp_path / "small.ply")
    with server.client() as client:
        job = server.run("embed", tmp_path / "small.ply", recipient="Ann", id="0000000000000007")
        found = server.run("trace", server.save(job, "model", tmp_path))
        (record,) = client.get("/api/registry/copies", params={"recipient": "Ann"}).json()["records"]
        nobody = client.get("/api/registry/copies", params={"recipient": "Bob"}).json()["records"]
    assert job["result"]["recipient"] == "Ann"
    assert [each["recipient"] for each in found["result"]["matches"]] == ["Ann"]
    assert (record["id"], record["original"]) == (job["result"]["id"], "small.ply")
    assert nobody == []
    assert record["path"] == "small_marked.ply", "its place on the server is gone in an hour"
    assert [each["kind"] for each in found["downloads"]] == ["report"]


def test_a_key_that_others_can_read_is_refused(server, pebble_file):
    path = server.keys / "open.key"
    Key(bytes(range(32))).save(path)
    try:
        path.chmod(0o644)
        job = server.run("extract", pebble_file, key="open")
        with server.client() as client:
            listed = {each["label"]: each for each in client.get("/api/keys").json()}
    finally:
        path.unlink()
    assert job["error"]["message"].startswith("other users can read the key file open.key")
    assert listed["open"]["fingerprint"] is None
    assert "other users can read" in listed["open"]["problem"]
