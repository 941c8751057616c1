"""Who may import whom, the sizes of files, and the public names, read from the source itself."""

from __future__ import annotations

import ast
import statistics
from pathlib import Path

import pytest

import meshmark
from tests.allowed import allowed
from tests.counting import some
from tests.imports import circles, folder_of, import_graph

ROOT = Path(meshmark.__file__).parent
SOURCES = sorted(ROOT.rglob("*.py"))
# A module imports from its own layer or from those before it; of the names here the longest that fits counts.
LAYERS = (
    "errors", "mesh", "coding", "geometry", "io", "saliency", "segmentation", "carriers", "network", "attacks",
    "metrics", "recovery", "report", "schemes.scheme", "schemes.ncdg_lv", "schemes.ncdg_lv.authentication",
    "schemes.rivals", "schemes.rivals.deep3d", "schemes.ablation", "schemes", "benchmark", "benchmark.paper", "cli",
    "", "__main__",
)  # fmt: skip
# Research: what only measures and trains. The product is all the rest, and imports none of it.
RESEARCH = (
    "benchmark", "schemes.rivals", "schemes.ablation", "schemes.table", "schemes.outside", "schemes.ncdg_lv.trials",
    "schemes.ncdg_lv.training", "schemes.ncdg_lv.authentication.region_trials",
    "schemes.ncdg_lv.authentication.region_training", "network.fitting", "network.levenberg_marquardt",
    "network.losses", "cli.bench", "cli.train",
)  # fmt: skip
LINES, MEDIAN = 300, 150
GRAPH = import_graph(ROOT)


def place(module: str) -> str:
    """Return the name of a module within meshmark, "" for meshmark itself."""
    return module.partition(".")[2]


def layer(module: str) -> int:
    """Return the number of a module's layer, -1 where it has none."""
    inside = [
        number
        for number, name in enumerate(LAYERS)
        if place(module) == name or (name and place(module).startswith(f"{name}."))
    ]
    return max(inside, key=lambda number: len(LAYERS[number]), default=-1)


def is_research(module: str) -> bool:
    return any(place(module) == name or place(module).startswith(f"{name}.") for name in RESEARCH)


def edges(graph) -> list[tuple[str, str]]:
    return some((one, other) for one, others in sorted(graph.items()) for other in sorted(others))


def test_every_module_has_a_layer():
    assert [name for name in GRAPH if layer(name) < 0] == []


def test_every_name_of_the_tables_is_one_of_the_package():
    known = {place(name) for name in GRAPH}
    assert {*LAYERS, *RESEARCH} - known == set()


def test_imports_run_downwards():
    upward = [f"{one} -> {other}" for one, other in edges(GRAPH) if layer(other) > layer(one)]
    assert upward == allowed("upward_imports")


def test_no_modules_import_in_a_circle():
    """Each circle is shown once, by a shortest way round."""
    assert [" -> ".join(way) for way in circles(GRAPH)] == allowed("import_circles")


def test_no_folders_import_in_a_circle():
    """A folder without its subfolders is a node; modules at the top are nodes of their own, as the layers are."""
    home = {name: name if folder_of(name, ROOT) == ROOT.name else folder_of(name, ROOT) for name in GRAPH}
    folders: dict[str, set[str]] = {folder: set() for folder in home.values()}
    for one, other in edges(GRAPH):
        folders[home[one]] |= {home[other]} - {home[one]}
    assert [" -> ".join(way) for way in circles(folders)] == allowed("folder_circles")


def test_the_product_imports_no_research():
    found = [
        f"{one} -> {other}" for one, other in edges(GRAPH) if not is_research(one) and is_research(other)
    ]
    assert found == allowed("product_imports_research")


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


def test_unknown_public_names_are_refused():
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        meshmark.nonsense  # noqa: B018
