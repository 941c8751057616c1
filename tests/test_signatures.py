"""Signatures that can be read where they are called: few positional parameters, and fields by their names."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import meshmark
from tests.counting import some

ROOT = Path(meshmark.__file__).parent
MOST_POSITIONAL, LEAST_FIELDS = 5, 3
# Dataclasses whose fields may be positional, and why.
POSITIONAL_DATACLASSES = (
    "mesh.py: Mesh",  # Mesh(vertices, faces, document) is the constructor that users know from other libraries
)


def product() -> Iterator[tuple[str, ast.Module]]:
    """Yield the name and the syntax tree of each module of the product: all but research."""
    for path in some(sorted(ROOT.rglob("*.py")), least=200):
        name = path.relative_to(ROOT).as_posix()
        if not name.startswith("research/"):
            yield name, ast.parse(path.read_text(encoding="utf-8"))


def crowded(tree: ast.Module) -> list[str]:
    """Return the names of functions with more positional parameters than MOST_POSITIONAL, self and cls left out."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            names = [item.arg for item in (*node.args.posonlyargs, *node.args.args)]
            if len(names) - (names[:1] in (["self"], ["cls"])) > MOST_POSITIONAL:
                found.append(getattr(node, "name", "lambda"))
    return found


def positional_dataclasses(tree: ast.Module) -> list[str]:
    """Return the names of dataclasses with LEAST_FIELDS fields and more that are not keyword-only."""
    found = []
    for node in (node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)):
        made = [text for item in node.decorator_list if "dataclass" in (text := ast.unparse(item))]
        fields = [
            item
            for item in node.body
            if isinstance(item, ast.AnnAssign) and "ClassVar" not in ast.unparse(item.annotation)
        ]
        if made and len(fields) >= LEAST_FIELDS and "kw_only=True" not in made[0]:
            found.append(node.name)
    return found


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("def f(a, b, c, d, e): ...", []),
        ("def f(a, b, c, d, e, g): ...", ["f"]),
        ("def f(a, b, c, /, d, e, g=1): ...", ["f"]),
        ("def f(a, b, c, d, e, *, g): ...", []),
        ("class C:\n    def f(self, a, b, c, d, e): ...", []),
        ("class C:\n    @classmethod\n    async def f(cls, a, b, c, d, e, g): ...", ["f"]),
        ("key = lambda a, b, c, d, e, g: a", ["lambda"]),
    ],
)
def test_crowded_functions_are_found(text, expected):
    assert crowded(ast.parse(text)) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("@dataclass\nclass C:\n    a: int\n    b: int", []),
        ("@dataclass\nclass C:\n    a: int\n    b: int\n    c: int = 1", ["C"]),
        ("@dataclass(frozen=True)\nclass C:\n    a: int\n    b: int\n    c: int", ["C"]),
        ("@dataclass(frozen=True, kw_only=True)\nclass C:\n    a: int\n    b: int\n    c: int", []),
        ("@dataclass\nclass C:\n    a: int\n    b: int\n    c: ClassVar[int] = 1", []),
        ("class C:\n    a: int\n    b: int\n    c: int", []),
    ],
)
def test_positional_dataclasses_are_found(text, expected):
    assert positional_dataclasses(ast.parse(text)) == expected


def test_no_function_of_the_product_has_many_positional_parameters():
    found = {f"{name}: {function}" for name, tree in product() for function in crowded(tree)}
    assert found == set(), "bundle what belongs together, or make it keyword-only"


def test_dataclasses_of_the_product_are_keyword_only():
    found = {f"{name}: {made}" for name, tree in product() for made in positional_dataclasses(tree)}
    assert found == {*POSITIONAL_DATACLASSES}
