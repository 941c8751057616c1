"""Who may import whom, the sizes of files, and the public names, read from the source itself."""

from __future__ import annotations

import ast
import statistics
import subprocess
import sys
from pathlib import Path

import pytest

import meshmark
import meshmark.io
import meshmark.marking
from tests.counting import some
from tests.imports import Graph, circles, folder_of, import_graph

ROOT = Path(meshmark.__file__).parent
SOURCES = sorted(ROOT.rglob("*.py"))
# A module imports from its own layer or from those before it.
LAYERS = (
    "errors", "late", "kernels", "notebook", "data", "arrays", "document", "mesh", "threads", "workers",
    "strengths", "coding", "geometry", "io", "scene", "saliency", "segmentation", "network", "certificate",
    "ownership", "recovery", "authentication", "marking", "registry", "attacks", "metrics", "report", "batch",
    "cli", "registry_commands", "", "__main__", "web", "research",
)  # fmt: skip
# The same of the folders within a folder.
INSIDE = {
    "io": ("text", "obj", "off", "ply", "stl", "gltf", "threemf"),
    "ownership": ("carriers", "points", "search"),
    "authentication": ("payload", "marks", "checks", "regions"),
    "research": ("schemes", "training", "ablation", "benchmark", "cli"),
    "research.benchmark": ("run", "figures", "page", "paper"),
}
# What several files may be called: each is the same part of another whole.
ROLES = {
    "attributes": "what a file format keeps of each vertex",
    "convert": "the writer of a file format",
    "parse": "the reader of a file format",
    "parameters": "the constants of a layer of marks",
    "table": "the table of a family",
    "analysis": "what a command shows of one model",
}
LINES, MEDIAN = 300, 150


def whole_graph() -> Graph:
    """Return who imports whom; read when first asked for, as every process of the tests imports this file."""
    return import_graph(ROOT)


def place(module: str) -> str:
    """Return the name of a module within meshmark, "" for meshmark itself."""
    return module.partition(".")[2]


def layer(module: str) -> int:
    """Return the number of a module's layer, -1 where it has none."""
    first = place(module).partition(".")[0]
    return LAYERS.index(first) if first in LAYERS else -1


def child(module: str, folder: str) -> str | None:
    """Return the part of a folder, a module or a folder within it, that a module belongs to; None outside of it.

    The folder's own __init__ is the part that is called as the folder is.
    """
    if module == folder:
        return module
    inside = module.removeprefix(f"{folder}.")
    return None if inside == module else f"{folder}.{inside.partition('.')[0]}"


def within(graph, folder: str) -> dict[str, set[str]]:
    """Return which parts of a folder import which."""
    parts: dict[str, set[str]] = {}
    for one, others in graph.items():
        if (here := child(one, folder)) is not None:
            found = {child(other, folder) for other in others} - {None, here}
            parts.setdefault(here, set()).update(found)
    return parts


def is_outside(module: str) -> bool:
    """Return whether a module is in a wheel of its own."""
    return place(module).partition(".")[0] in ("registry_commands", "research", "web")


def edges(graph) -> list[tuple[str, str]]:
    return some((one, other) for one, others in sorted(graph.items()) for other in sorted(others))


def test_every_module_has_a_layer():
    assert [name for name in whole_graph() if layer(name) < 0] == []


def test_every_name_of_the_tables_is_one_of_the_package():
    known = {place(name) for name in whole_graph()}
    assert {*LAYERS, *INSIDE} - known == set()
    for folder, parts in some(INSIDE.items()):
        assert {f"{folder}.{part}" for part in parts} - known == set()


def test_imports_run_downwards():
    upward = [f"{one} -> {other}" for one, other in edges(whole_graph()) if layer(other) > layer(one)]
    assert upward == []


@pytest.mark.parametrize("folder", INSIDE)
def test_imports_run_downwards_within_a_folder(folder):
    order = [f"{ROOT.name}.{folder}.{part}" for part in INSIDE[folder]]
    upward = [
        f"{one} -> {other}"
        for one, others in within(whole_graph(), f"{ROOT.name}.{folder}").items()
        for other in others
        if one in order and other in order and order.index(other) > order.index(one)
    ]
    assert upward == []


def test_no_modules_import_in_a_circle():
    """Each circle is shown once, by a shortest way round."""
    assert [" -> ".join(way) for way in circles(whole_graph())] == []


def test_the_parts_of_no_folder_import_in_a_circle():
    """The modules and folders within a folder; a folder within counts as one, whichever of its modules imports."""
    folders = some((name for name in whole_graph() if folder_of(name, ROOT) == name), least=30)
    found = [" -> ".join(way) for folder in folders for way in circles(within(whole_graph(), folder))]
    assert found == []


def test_the_product_imports_no_research_no_commands_of_the_registry_and_nothing_of_the_web():
    found = [
        f"{one} -> {other}" for one, other in edges(whole_graph()) if is_outside(other) > is_outside(one)
    ]
    assert found == []


def test_a_file_name_means_one_thing():
    """A module is named after what is in it; those in the folders `cli` are named after their commands."""
    folders = {name for name in whole_graph() if folder_of(name, ROOT) == name}
    homes: dict[str, list[str]] = {}
    for name in sorted(whole_graph().keys() - folders):
        home, _, last = name.rpartition(".")
        if not home.endswith(".cli"):
            homes.setdefault(last, []).append(home)
    repeated = {last: found for last, found in homes.items() if len(found) > 1}
    assert {last: found for last, found in repeated.items() if last not in ROLES} == {}
    assert ROLES.keys() - repeated.keys() == set(), "a role that is not repeated is none"


def test_files_are_short():
    lengths = {str(path.relative_to(ROOT)): len(path.read_text().splitlines()) for path in SOURCES}
    assert {name: length for name, length in lengths.items() if length > LINES} == {}
    assert statistics.median(lengths.values()) <= MEDIAN


def test_modules_say_what_they_are_and_what_they_offer():
    silent, unlisted = [], []
    for path in some(SOURCES, least=300):
        tree, name = ast.parse(path.read_text()), str(path.relative_to(ROOT))
        if tree.body and not ast.get_docstring(tree):
            silent.append(name)
        offers = any(
            isinstance(node, ast.Assign | ast.AnnAssign) and "__all__" in ast.dump(node) for node in tree.body
        )
        public = [
            node.name
            for node in tree.body
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_")
        ]
        if public and not offers:
            unlisted.append(name)
    assert silent == [], "a module begins with what it is for"
    assert unlisted == [], "public names without __all__"


def test_public_names_exist_and_are_documented():
    listed = dir(meshmark)
    assert [name for name in some(meshmark.__all__) if not getattr(meshmark, name).__doc__] == []
    assert [name for name in meshmark.__all__ if name not in listed] == []


@pytest.mark.parametrize("package", [meshmark, meshmark.io, meshmark.marking], ids=lambda item: item.__name__)
def test_the_names_of_a_package_are_found_when_they_are_asked_for(package):
    assert [name for name in some(package.__all__) if not hasattr(package, name)] == []
    assert set(package.__all__) <= set(dir(package))
    with pytest.raises(AttributeError, match=f"module '{package.__name__}' has no attribute 'nonsense'"):
        package.nonsense  # noqa: B018


def test_embedding_loads_what_it_needs_only():
    """No format of a file, no search for a damaged mark and no recovery, until they are called for."""
    program = "import sys, meshmark; meshmark.embed; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    loaded = {place(name) for name in run.stdout.split() if name.startswith("meshmark.")}
    late = (
        "io.formats", "io.source", "io.save", "io.ply", "io.gltf", "ownership.search.restored", "recovery.repair",
        "ownership.demodulator", "geometry.registration", "authentication.verdict", "saliency", "segmentation",
    )  # fmt: skip
    assert "marking.both_layers" in loaded
    assert [name for name in late if name in loaded] == []
    other = {"cryptography", "jinja2", "rich", "fast_simplification", "scipy.linalg", "scipy.spatial"}
    assert other & set(run.stdout.split()) == set()
