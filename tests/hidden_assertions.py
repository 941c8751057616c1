"""Finds assertions that may never run, from the syntax tree of a test file.

Assertions are `assert`, `np.testing.assert_...` and `pytest.raises`. One is hidden where it stands

- under a condition (`if`, `while`, `except`, a `try` whose exceptions are caught, or after a `return`,
  `continue` or `break` under a condition) with no `asserted()` of a `tests.counting.Share` beside it,
- in a loop, or in an `all(...)` or `any(...)`, over what may be empty: neither a literal, nor a range of
  constants, nor `tests.counting.some(...)`,
- in a block of `pytest.raises`, which ends before it.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field

EXITS = (ast.Return, ast.Continue, ast.Break)
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)
# Calls that have as many items as their first argument, and those of the standard containers.
ALIKE = {"enumerate", "sorted", "reversed", "list", "tuple", "set", "iter", "zip"}
VIEWS = {"items", "keys", "values"}


@dataclass(frozen=True, kw_only=True)
class Hidden:
    """An assertion that may never run: its line, and why."""

    line: int
    why: str


@dataclass(frozen=True, kw_only=True)
class Place:
    """What stands around a statement: the conditions that are not counted, and the names sure to hold something."""

    why: tuple[str, ...] = ()
    sure: frozenset[str] = field(default_factory=frozenset)

    def under(self, why: str) -> Place:
        return Place(why=(*self.why, why), sure=self.sure)


def hidden_assertions(source: str) -> list[Hidden]:
    """Return the assertions of a file that may never run."""
    tree = ast.parse(source)
    return list(in_block(tree.body, Place(sure=frozenset(literals(tree.body)))))


def literals(body: list[ast.stmt]) -> Iterator[str]:
    """Yield the names that a block gives a literal with something in it."""
    for node in body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names = [target.id for target in targets if isinstance(target, ast.Name)]
            if holds_something(node.value, frozenset()):
                yield from names


def holds_something(node: ast.expr, sure: frozenset[str]) -> bool:
    """Return whether the items of an expression are sure not to be none."""
    match node:
        case ast.Tuple(elts=elts) | ast.List(elts=elts) | ast.Set(elts=elts):
            return any(
                not isinstance(each, ast.Starred) or holds_something(each.value, sure) for each in elts
            )
        case ast.Dict(keys=keys, values=values):
            return any(key or holds_something(value, sure) for key, value in zip(keys, values, strict=True))
        case ast.Constant(value=str(text)):
            return bool(text)
        case ast.Name(id=name):
            return name in sure
        case ast.Call(func=ast.Name(id="some")) | ast.Call(func=ast.Attribute(attr="some")):
            return True
        case ast.Call(func=ast.Name(id="range"), args=args):
            if not all(isinstance(each, ast.Constant) for each in args):
                return False
            return bool(len(range(*(each.value for each in args if isinstance(each, ast.Constant)))))
        case ast.Call(func=ast.Name(id="zip"), args=args, keywords=[ast.keyword(arg="strict"), *_]):
            return any(holds_something(each, sure) for each in args)
        case ast.Call(func=ast.Name(id=name), args=[*args]) if name in ALIKE and args:
            return all(holds_something(each, sure) for each in args if not isinstance(each, ast.Lambda))
        case ast.Call(func=ast.Attribute(value=value, attr=name)) if name in VIEWS:
            return holds_something(value, sure)
        case (
            ast.ListComp(generators=generators)
            | ast.SetComp(generators=generators)
            | ast.DictComp(generators=generators)
            | ast.GeneratorExp(generators=generators)
        ):
            return not any(each.ifs for each in generators) and all(
                holds_something(each.iter, sure) for each in generators
            )
    return False


def in_block(body: list[ast.stmt], place: Place) -> Iterator[Hidden]:
    """Yield what is hidden in a block of statements."""
    if any(counts(node) for node in body):
        place = Place(sure=place.sure)
    for node in body:
        place = Place(why=place.why, sure=place.sure | set(literals([node])))
        yield from in_statement(node, place)
        if leaves(node) and not any(counts(other) for other in body):
            place = place.under(f"line {node.lineno} may leave before")


def in_statement(node: ast.stmt, place: Place) -> Iterator[Hidden]:
    """Yield what is hidden in a statement."""
    match node:
        case ast.Assert():
            yield from (Hidden(line=node.lineno, why=why) for why in place.why[-1:])
            if not place.why:
                yield from in_test(node, place)
        case ast.FunctionDef(body=body) | ast.AsyncFunctionDef(body=body) | ast.ClassDef(body=body):
            yield from in_block(body, Place(sure=place.sure))
        case ast.For(body=body, orelse=orelse):
            sure = holds_something(node.iter, place.sure)
            inner = place if sure else place.under(f"a loop over {ast.unparse(node.iter)}")
            yield from in_block(body, inner)
            yield from in_block(orelse, place)
        case ast.If(body=body, orelse=orelse) | ast.While(body=body, orelse=orelse):
            inner = place.under(f"only where {ast.unparse(node.test)}")
            yield from in_block(body, inner)
            yield from in_block(orelse, inner)
        case ast.Try(body=body, handlers=handlers, orelse=orelse, finalbody=final):
            yield from in_block(body, place.under("its failure is caught") if handlers else place)
            for handler in handlers:
                yield from in_block(handler.body, place.under("only after an exception"))
            yield from in_block(orelse, place.under("only without an exception"))
            yield from in_block(final, place)
        case ast.With(items=items, body=body):
            raising = any("pytest.raises" in ast.unparse(each.context_expr) for each in items)
            if raising and place.why:
                yield Hidden(line=node.lineno, why=place.why[-1])
            yield from in_block(body, place.under("pytest.raises leaves before") if raising else place)
        case ast.Expr(value=ast.Call(func=ast.Attribute(attr=name))) if name.startswith("assert_"):
            yield from (Hidden(line=node.lineno, why=why) for why in place.why[-1:])
        case ast.Match(cases=cases):
            for case in cases:
                yield from in_block(case.body, place.under("only in a case of a match"))


def in_test(node: ast.Assert, place: Place) -> Iterator[Hidden]:
    """Yield the assertion where it is about all of what may be nothing."""
    for call in ast.walk(node.test):
        match call:
            case ast.Call(func=ast.Name(id="all" | "any" as name), args=[ast.GeneratorExp() as items]):
                if name == "any" and not negated(call, node.test):
                    continue
                for each in items.generators[:1]:
                    if not holds_something(each.iter, place.sure):
                        yield Hidden(line=node.lineno, why=f"{name} of {ast.unparse(each.iter)}")


def negated(call: ast.expr, test: ast.expr) -> bool:
    """Return whether a call stands right behind a `not`."""
    return any(
        isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not) and node.operand is call
        for node in ast.walk(test)
    )


def counts(node: ast.stmt) -> bool:
    """Return whether a statement is `share.asserted()`."""
    match node:
        case ast.Expr(value=ast.Call(func=ast.Attribute(attr="asserted"))):
            return True
    return False


def leaves(node: ast.stmt) -> bool:
    """Return whether a statement may leave the block around it, under a condition."""
    if not isinstance(node, ast.If | ast.Try | ast.For | ast.While | ast.With | ast.Match):
        return False
    return exits(node, frozenset(EXITS))


def exits(node: ast.AST, ways: frozenset[type[ast.AST]]) -> bool:
    """Return whether one of the statements that leave a block stands in a node, and leaves it."""
    if isinstance(node, ast.For | ast.While):
        ways = frozenset({ast.Return})  # the others end the loop only
    return any(
        type(child) in ways or exits(child, ways)
        for child in ast.iter_child_nodes(node)
        if not isinstance(child, FUNCTIONS)
    )
