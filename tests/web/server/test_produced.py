"""What a job made: names without places, archives of several files, and the view of a report."""

from __future__ import annotations

import zipfile
from pathlib import Path

from meshmark.web.server.produced import downloads_of, own_names, view_of
from meshmark.web.server.web_job import Download


def test_answers_name_files_as_the_upload_did(tmp_path):
    keys, folder = tmp_path / "keys", tmp_path / "job"
    answer = {
        "input": "in/ear.glb",
        "outputs": {"model": "out/ear_marked.glb"},
        "side_files": [f"{folder}/out/textures/skin.png"],
        "error": {"message": f"other users can read the key file {keys}/a.key", "file": f"{keys}/a.key"},
        "words": "Marked: in/ear.glb -> out/ear_marked.glb; within/without",
        "seconds": 3.0,
    }
    assert own_names(answer, (folder, keys)) == {
        "input": "ear.glb",
        "outputs": {"model": "ear_marked.glb"},
        "side_files": ["textures/skin.png"],
        "error": {"message": "other users can read the key file a.key", "file": "a.key"},
        "words": "Marked: ear.glb -> ear_marked.glb; within/without",
        "seconds": 3.0,
    }


def test_a_model_of_several_files_is_one_archive_and_other_files_are_themselves(tmp_path):
    for name in ("ear.gltf", "ear.bin", "textures/skin.png", "ear.cert"):
        path = tmp_path / "out" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(name)
    answer = {
        "outputs": {"model": "out/ear.gltf", "certificate": "out/ear.cert"},
        "side_files": ["out/ear.bin", str(tmp_path / "out" / "textures" / "skin.png")],
    }
    model, certificate = downloads_of(tmp_path, answer)
    assert (model.kind, model.name, certificate.name, certificate.bytes) == (
        "model",
        "ear.zip",
        "ear.cert",
        8,
    )
    with zipfile.ZipFile(model.path) as archive:
        found = {name: archive.read(name).decode() for name in archive.namelist()}
    assert found == {name: name for name in ("ear.gltf", "ear.bin", "textures/skin.png")}


def test_the_view_of_a_report_is_taken_from_it(tmp_path):
    def report(text: str) -> Path | None:
        path = tmp_path / "report.html"
        path.write_text(text)
        download = Download(kind="report", name=path.name, path=path, bytes=len(text))
        return view_of([download], tmp_path)

    scripts = '<script id="v0">no</script><script type="application/json" id="v1">{"a": 1}</script>'
    assert report(f'<div data-view="v1"></div>{scripts}').read_text() == '{"a": 1}'
    assert report("<p>a report with pictures alone</p>") is None
    assert view_of([], tmp_path) is None
