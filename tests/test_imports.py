"""The reader of imports sees what it should: planted sources and graphs."""

from __future__ import annotations

import pytest

from tests.imports import circles, folder_of, import_graph, imported

KNOWN = ("m", "m.io", "m.io.ply", "m.cli", "m.cli.main")


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("def f():\n    from m.cli import main", {"m.cli.main"}),
        ("import m.io.ply as p", {"m.io.ply"}),
        ("from m import io", {"m.io"}),
        ("from m.io import read_mesh", {"m.io"}),
        ("from m import __version__", set()),
        ("if TYPE_CHECKING:\n    from m.cli import main", {"m.cli.main"}),
        ("import_module('m.cli')", {"m.cli"}),
        ("import numpy as np\nfrom os import path", set()),
    ],
)
def test_imports_are_found_wherever_they_stand(source, expected):
    assert imported(source, KNOWN) == expected


def test_relative_imports_are_refused():
    with pytest.raises(ValueError, match="line 1: a relative import"):
        imported("from .io import ply", KNOWN)


def test_modules_and_folders_have_their_dotted_names(tmp_path):
    root = tmp_path / "m"
    (root / "io").mkdir(parents=True)
    for name, text in {
        "__init__": "",
        "mesh": "import m.io.ply",
        "io/__init__": "",
        "io/ply": "from m import mesh",
    }.items():
        (root / f"{name}.py").write_text(text)
    assert import_graph(root) == {"m": set(), "m.mesh": {"m.io.ply"}, "m.io": set(), "m.io.ply": {"m.mesh"}}
    assert [folder_of(name, root) for name in ("m", "m.mesh", "m.io", "m.io.ply")] == [
        "m",
        "m",
        "m.io",
        "m.io",
    ]
    assert circles(import_graph(root)) == [["m.io.ply", "m.mesh", "m.io.ply"]]


def test_a_graph_without_circles_has_none():
    assert circles({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == []


def test_every_node_in_a_circle_is_in_one_that_is_shown_and_each_is_shown_once():
    ring = {"a": {"b"}, "b": {"c"}, "c": {"d", "a"}, "d": {"a"}, "e": {"f"}, "f": {"e"}, "g": {"a"}}
    assert circles(ring) == [["a", "b", "c", "a"], ["d", "a", "b", "c", "d"], ["e", "f", "e"]]
