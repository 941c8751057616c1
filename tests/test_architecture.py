"""The import rule, the sizes of files, and the public names, read from the source itself."""

from __future__ import annotations

import ast
import statistics
from pathlib import Path

import pytest

import meshmark

ROOT = Path(meshmark.__file__).parent
SOURCES = sorted(ROOT.rglob("*.py"))
# A module imports from its own layer or from those before it.
LAYERS = (
    "errors", "mesh", "coding", "geometry", "io", "saliency", "segmentation", "carriers", "network", "attacks",
    "metrics", "recovery", "report", "schemes", "benchmark", "cli",
)  # fmt: skip
# The file of public names and the program's entry stand above all layers; `TYPE_CHECKING` blocks do not run.
ABOVE = {"__init__", "__main__"}
LINES, MEDIAN = 300, 150


def layer(path: Path) -> str:
    return path.relative_to(ROOT).with_suffix("").parts[0]


def running(tree: ast.AST):
    """Yield the nodes of a tree without the blocks that only type checkers read."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            continue
        yield node
        yield from running(node)


def imported_layers(source: str) -> set[str]:
    """Return the layers of meshmark that a source text imports, anywhere in it, when it runs."""
    found = set()
    for node in running(ast.parse(source)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, "imports are absolute"
            names = [node.module or ""]
            if node.module == "meshmark":
                names = [f"meshmark.{alias.name}" for alias in node.names]
        else:
            continue
        found |= {name.split(".")[1] for name in names if name.startswith("meshmark.")}
    return found - {"__version__"}


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_run_downwards(path):
    own = layer(path)
    if own in ABOVE:
        return
    assert own in LAYERS, f"{own} has no place in the order of layers"
    allowed = set(LAYERS[: LAYERS.index(own) + 1])
    assert imported_layers(path.read_text()) <= allowed


def test_the_import_rule_sees_what_it_should():
    assert imported_layers("def f():\n    from meshmark.cli import main") == {"cli"}
    assert imported_layers("import meshmark.io.ply as p") == {"io"}
    assert imported_layers("from meshmark import schemes") == {"schemes"}
    assert imported_layers("if TYPE_CHECKING:\n    from meshmark.cli import main") == set()


def test_files_are_short():
    lengths = {str(path.relative_to(ROOT)): len(path.read_text().splitlines()) for path in SOURCES}
    assert {name: length for name, length in lengths.items() if length > LINES} == {}
    assert statistics.median(lengths.values()) <= MEDIAN


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_modules_say_what_they_are_and_what_they_offer(path):
    tree = ast.parse(path.read_text())
    assert ast.get_docstring(tree) or not tree.body, "a module begins with what it is for"
    offers = any(
        isinstance(node, ast.Assign | ast.AnnAssign) and "__all__" in ast.dump(node) for node in tree.body
    )
    public = [
        node.name
        for node in tree.body
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_")
    ]
    assert offers or not public, f"{public} without __all__"


@pytest.mark.parametrize("name", meshmark.__all__)
def test_public_names_exist_and_are_documented(name):
    assert getattr(meshmark, name).__doc__
    assert name in dir(meshmark)


def test_unknown_public_names_are_refused():
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        meshmark.nonsense  # noqa: B018
