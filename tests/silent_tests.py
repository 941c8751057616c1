"""Finds tests that assert nothing, neither themselves nor in a function of the tests that they call."""

from __future__ import annotations

import ast
from collections.abc import Mapping


def silent_tests(sources: Mapping[str, str]) -> list[str]:
    """Return "file: function" of each test that cannot fail; sources: the text of all files, by name."""
    trees = {name: ast.parse(text) for name, text in sources.items()}
    functions = [
        node for tree in trees.values() for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)
    ]
    calls = {id(node): called(node) for node in functions}
    speaking = {node.name for node in functions if asserts(node)}
    while more := {node.name for node in functions if calls[id(node)] & speaking} - speaking:
        speaking |= more
    return [
        f"{name}: {node.name}"
        for name, tree in trees.items()
        for node in tree.body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_") and node.name not in speaking
    ]


def called(node: ast.AST) -> set[str]:
    """Return the last names of all that is called in a node."""
    return {
        ast.unparse(call.func).rpartition(".")[2] for call in ast.walk(node) if isinstance(call, ast.Call)
    }


def asserts(node: ast.AST) -> bool:
    """Return whether an assertion stands in a node: `assert`, `pytest.raises`, `np.testing.assert_...`."""
    return any(isinstance(each, ast.Assert) for each in ast.walk(node)) or any(
        name == "raises" or name.startswith("assert_") for name in called(node)
    )
