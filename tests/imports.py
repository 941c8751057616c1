"""Who imports whom in a package, read from the source: also what is imported late or only for type checkers."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

Graph = Mapping[str, set[str]]


def module_name(path: Path, root: Path) -> str:
    """Return the dotted name of a file below the folder of a package; `root` is that folder."""
    parts = [root.name, *path.relative_to(root).with_suffix("").parts]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported(source: str, modules: Iterable[str]) -> set[str]:
    """Return which of the modules a source text imports, anywhere in it, `TYPE_CHECKING` blocks included."""
    known, found = set(modules), set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                raise ValueError(f"line {node.lineno}: a relative import, expected absolute ones")
            # `from package import name` is of the module package.name where there is one.
            names = [f"{node.module}.{alias.name}" for alias in node.names if alias.name != "__version__"]
            names = [name if name in known else str(node.module) for name in names]
        elif isinstance(node, ast.Constant):
            names = [str(node.value)] if "." in str(node.value) else []  # imported by its name later
        else:
            continue
        found |= {name for name in names if name in known}
    return found


@cache
def import_graph(root: Path) -> dict[str, set[str]]:
    """Return, for each module of a package, the modules of it that it imports."""
    paths = {module_name(path, root): path for path in sorted(root.rglob("*.py"))}
    return {name: imported(path.read_text(encoding="utf-8"), paths) - {name} for name, path in paths.items()}


def folder_of(module: str, root: Path) -> str:
    """Return the dotted name of the folder that a module lies in."""
    return module if (root.parent / Path(*module.split("."))).is_dir() else module.rpartition(".")[0]


def circles(graph: Graph) -> list[list[str]]:
    """Return a shortest way from each node back to itself, [a, b, c, a]; the same one only once."""
    found: dict[frozenset[str], list[str]] = {}
    for start in sorted(graph):
        if way := shortest_circle(graph, start):
            found.setdefault(frozenset(way), way)
    return list(found.values())


def shortest_circle(graph: Graph, start: str) -> list[str]:
    """Return the shortest way from a node back to itself, [] where there is none."""
    before: dict[str, str] = {}
    ways = [start]
    while ways:
        following = []
        for node in ways:
            for other in sorted(graph[node]):
                if other == start:
                    way = [node]
                    while way[-1] != start:
                        way.append(before[way[-1]])
                    return [*reversed(way), start]
                if other not in before:
                    before[other] = node
                    following.append(other)
        ways = following
    return []
