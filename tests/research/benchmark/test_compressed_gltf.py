"""The command that measures compressed glTF: its choice of models, its broken files, its store."""

from __future__ import annotations

import hashlib
import json
import struct
from pathlib import Path
from typing import Any

import pytest

from claims.compressed_gltf import hostile, models
from claims.compressed_gltf.hostile import KINDS, broken, harmful, measure_hostile
from claims.compressed_gltf.models import candidates, marked_models
from claims.compressed_gltf.store import Broken
from meshmark.errors import CapacityError, FormatError
from tests.io.compressed_samples import draco_grid, with_meshopt
from tests.io.gltf_samples import cube

COPIES = {"draco": draco_grid().glb(False), "meshopt": with_meshopt(cube()).glb(False)}


def parts(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the JSON and the binary chunk of a GLB."""
    size = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def row(**given: Any) -> Broken:
    plain = {"file": "a", "kind": "cut", "number": 0, "outcome": "refused", "own": 50, "child": 50}
    return Broken(**{**plain, "seconds": 1.0, "message": "", **given})


def test_models_come_in_the_order_of_their_digests_and_equal_files_once(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    for name, data in (("a.glb", b"1"), ("b.glb", b"2"), ("deep/c.glb", b"1"), ("d.gltf", b"3")):
        (tmp_path / name).write_bytes(data)
    found = candidates(tmp_path)
    assert [digest for digest, _ in found] == sorted(
        hashlib.sha256(data).hexdigest() for data in (b"1", b"2")
    )


def test_refused_models_are_kept_in_the_list_and_no_model_is_tried_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Made:
        id = 7

    def mark(path: Path, out: Path, key: object) -> Made:
        tried.append(path.name)
        if path.name == "0.glb":
            raise CapacityError("too few points")
        if path.name == "1.glb":
            raise FormatError("not a mesh")
        return Made()

    tried: list[str] = []
    for number in range(6):
        (tmp_path / f"{number}.glb").write_bytes(bytes([number]))
    monkeypatch.setattr(models, "embed_file", mark)
    monkeypatch.setattr(
        models, "candidates", lambda folder: [(str(n), folder / f"{n}.glb") for n in range(6)]
    )
    assert [model.refused for model in marked_models(tmp_path, tmp_path, 2)] == ["capacity", "other", "", ""]
    assert [model.refused for model in marked_models(tmp_path, tmp_path, 3)] == [
        "capacity",
        "other",
        "",
        "",
        "",
    ]
    assert tried == [f"{number}.glb" for number in range(5)]


@pytest.mark.parametrize("form", COPIES)
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "miscounted"])
def test_streams_are_broken_and_nothing_else(form: str, kind: str) -> None:
    before, after = parts(COPIES[form]), parts(broken(COPIES[form], kind, (3,)))
    assert before[0] == after[0]
    assert len(before[1]) == len(after[1])
    assert before[1] != after[1] or (form, kind) == ("draco", "swapped")  # its only stream, with itself


@pytest.mark.parametrize("form", COPIES)
def test_counts_are_changed_and_no_bytes(form: str) -> None:
    before, after = parts(COPIES[form]), parts(broken(COPIES[form], "miscounted", (3,)))
    assert before[0] != after[0]
    assert before[1] == after[1]


def test_what_harm_is() -> None:
    assert not harmful(row())
    assert not harmful(row(outcome="read"))
    for harm in (
        {"outcome": "crash"},
        {"outcome": "hang"},
        {"own": 1024},
        {"child": 2000},
        {"seconds": 30.0},
    ):
        assert harmful(row(**harm))


def test_a_broken_file_is_read_once_in_a_process_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copy = tmp_path / "00000001.draco.glb"
    copy.write_bytes(COPIES["draco"])
    first = measure_hostile([copy], 1, tmp_path)
    assert [found.kind for found in first] == list(KINDS)
    assert [found for found in first if harmful(found)] == []
    monkeypatch.setattr(hostile, "probe", lambda _: pytest.fail("it was read again"))
    assert measure_hostile([copy], 1, tmp_path) == first
