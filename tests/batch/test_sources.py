"""The models of a batch: those of a folder, of a pattern, or of a list."""

from __future__ import annotations

from pathlib import Path

import pytest

from meshmark.batch.sources import Item, items
from meshmark.errors import InputError


@pytest.fixture
def models(tmp_path: Path) -> Path:
    folder = tmp_path / "models"
    for name in (
        "b.ply",
        "a.obj",
        "a.mtl",
        "deep/er/c.GLB",
        "deep/notes.txt",
        ".hidden/d.ply",
        "deep/e.stl.gz",
    ):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("")
    return folder


def names(source: object, out: Path) -> list[str]:
    return [item.name for item in items(str(source), out)]


def test_a_folder_gives_its_models_and_those_below_in_order(models):
    assert names(models, models / "out") == ["a.obj", "b.ply", "deep/e.stl.gz", "deep/er/c.GLB"]
    first = next(items(str(models), models / "out"))
    assert first == Item(name="a.obj", path=models / "a.obj")


def test_results_below_the_folder_are_no_models(models):
    assert names(models, models / "deep") == ["a.obj", "b.ply"]
    assert names(models / "**/*.*", models / "deep") == ["a.obj", "b.ply"]


def test_a_pattern_names_models_below_its_fixed_part(models):
    assert names(models / "*" / "**" / "*.GLB", models / "out") == ["deep/er/c.GLB"]
    with pytest.raises(InputError, match="matches no model"):
        names(models / "*.fbx", models / "out")


def test_a_model_is_a_batch_of_one(models):
    assert names(models / "b.ply", models / "out") == ["b.ply"]


def test_a_list_names_models_relative_to_itself_or_by_whole_paths(models, tmp_path):
    outside = tmp_path / "other.ply"
    (models / "list.txt").write_text(f"# two\nb.ply\n\n{outside}  # not there\n")
    found = list(items(str(models / "list.txt"), models / "out"))
    assert [item.name for item in found] == ["b.ply", str(outside).lstrip("/")]
    assert found[0].path == models / "b.ply"


def test_a_table_gives_ids_and_recipients(models):
    (models / "table.csv").write_text("recipient,path,id\nAda,b.ply,00000000000000aa\n,a.obj,\n")
    assert list(items(str(models / "table.csv"), models / "out")) == [
        Item(name="b.ply", path=models / "b.ply", id="00000000000000aa", recipient="Ada"),
        Item(name="a.obj", path=models / "a.obj"),
    ]


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("none", None, "is not there"),
        ("t.csv", b"name\nb.ply\n", "has no column `path`"),
        ("t.csv", b"path,id\n,aa\n", "line 2: the column `path` is empty"),
        ("t.csv", b'path\n"b.ply\n', "is no table"),
        ("t.csv", b"path\n\xff\n", "is no text"),
        ("t.txt", b"\xff\xfe\xff", "is no text"),
    ],
)
def test_what_is_no_source_is_refused(models, name, content, says):
    if content is not None:
        (models / name).write_bytes(content)
    with pytest.raises(InputError, match=says):
        names(models / name, models / "out")
