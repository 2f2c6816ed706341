"""Small faults that a line of code could have, one at a time.

mutmut and cosmic-ray change one source of a whole project and start a test run of their own for
each; what is wanted here is a seeded sample by module, faults of numerics (a term dropped, axes or
subscripts swapped), a cold cache for compiled code, and tests chosen by the lines they run.
"""

from __future__ import annotations

import ast
import random
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

ARITHMETIC = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}
EDGES = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}
OPPOSITES = {
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
DROPPED = {
    "abs", "absolute", "fabs", "sqrt", "square", "floor", "ceil", "rint", "negative", "sort",
    "cumsum", "transpose", "max", "maximum", "min", "minimum", "conj", "swapaxes", "roll",
}  # fmt: skip
SYMMETRIC = {
    "maximum", "minimum", "max", "min", "add", "multiply", "hypot", "isclose", "allclose",
    "array_equal", "isinstance", "issubclass", "zip", "cast", "range", "getattr", "setattr",
    "logical_and", "logical_or", "print", "partial", "map",
}  # fmt: skip
NUMBERS = ("float", "Array", "int", "NDArray", "ndarray")


@dataclass(frozen=True)
class Mutant:
    """One fault: the text between two places of a file, and what stands there instead."""

    file: str
    line: int
    kind: str
    start: int
    end: int
    before: str
    after: str

    def name(self) -> str:
        """Return what tells this fault from all others of the same source."""
        return f"{self.file}:{self.start}:{self.end}:{self.kind}:{self.after}"

    def applied(self, source: str) -> str:
        """Return the source with the fault; places count bytes."""
        raw = source.encode()
        return (raw[: self.start] + self.after.encode() + raw[self.end :]).decode()


def mutants(file: str, source: str) -> list[Mutant]:
    """Return all faults of a file that leave it valid Python."""
    starts = [0]
    for line in source.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def place(node: ast.AST) -> tuple[int, int]:
        return (
            starts[node.lineno - 1] + node.col_offset,
            starts[node.end_lineno - 1] + node.end_col_offset,
        )

    found = {}
    for node, returns in _reached(ast.parse(source), ""):
        start, end = place(node)
        before = source.encode()[start:end].decode()
        for kind, after in _faults(node, returns):
            one = Mutant(file, node.lineno, kind, start, end, before, after)
            if _valid(one, source):
                found.setdefault((start, end, after), one)
    return list(found.values())


def sample(found: list[Mutant], count: int, seed: str) -> list[Mutant]:
    """Return at most `count` faults, kinds in turn, since constants are many; lines once, if so
    many lines there are."""
    rng = random.Random(seed)  # noqa: S311  nothing secret
    taken: list[Mutant] = []
    while len(taken) < min(count, len(found)):
        kinds = defaultdict(list)
        for one in found:
            if one not in taken:
                kinds[one.kind].append(one)
        for group in kinds.values():
            rng.shuffle(group)
        lines = set()
        while any(kinds.values()):
            names = [k for k in sorted(kinds) if kinds[k]]
            rng.shuffle(names)
            for name in names:
                while kinds[name]:
                    one = kinds[name].pop()
                    if (one.file, one.line) not in lines:
                        lines.add((one.file, one.line))
                        taken.append(one)
                        break
    return taken[:count]


def _valid(one: Mutant, source: str) -> bool:
    try:
        return ast.dump(ast.parse(one.applied(source))) != ast.dump(ast.parse(source))
    except SyntaxError:
        return False


def _reached(node: ast.AST, returns: str) -> Iterator[tuple[ast.AST, str]]:
    """Nodes that compute something; `returns`: what the function around them gives."""
    if isinstance(node, ast.FunctionDef):
        returns = ast.unparse(node.returns) if node.returns else ""
    if isinstance(node, (ast.expr, ast.stmt)):
        yield node, returns
    for child in _below(node):
        yield from _reached(child, returns)


def _below(node: ast.AST) -> list[ast.AST]:
    """Parts of a node, without types, texts and decorators."""
    if isinstance(node, ast.FunctionDef):
        return [*node.args.defaults, *filter(None, node.args.kw_defaults), *node.body]
    if isinstance(node, (ast.ClassDef, ast.ExceptHandler)):
        return list(node.body)
    if isinstance(node, ast.Lambda):
        return [node.body]
    if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
        return list(node.orelse)
    if isinstance(node, ast.AnnAssign):
        return [node.value] if node.value else []
    return [] if _says(node) else list(ast.iter_child_nodes(node))


def _says(node: ast.AST) -> bool:
    """Whether a node is of names, texts or types alone, or says how to compile."""
    if isinstance(node, ast.Expr):
        return isinstance(node.value, ast.Constant)  # a docstring
    if isinstance(node, ast.Call):
        return ast.unparse(node.func) in {"compiled", "dataclass"}
    if isinstance(node, ast.Assign):
        is_type = isinstance(node.value, ast.Subscript) and ast.unparse(node.value.value) in {
            "Literal", "Callable",
        }  # fmt: skip
        return is_type or ast.unparse(node.targets[0]).startswith("__")
    return isinstance(node, (ast.Raise, ast.JoinedStr, ast.Import, ast.ImportFrom))


def _faults(node: ast.AST, returns: str) -> Iterator[tuple[str, str]]:  # noqa: C901, PLR0912
    if isinstance(node, ast.BinOp):
        yield from _of_sum(node)
    elif isinstance(node, ast.Constant):
        yield from _of_constant(node.value)
    elif isinstance(node, ast.Compare) and len(node.ops) == 1:
        for table, kind in ((EDGES, "edge"), (OPPOSITES, "opposite")):
            if type(node.ops[0]) in table:
                yield kind, _with(node, ops=[table[type(node.ops[0])]()])
    elif isinstance(node, ast.BoolOp):
        yield "and/or", _with(node, op=ast.Or() if isinstance(node.op, ast.And) else ast.And())
    elif isinstance(node, ast.UnaryOp):
        kind = "not dropped" if isinstance(node.op, (ast.Not, ast.Invert)) else "sign dropped"
        yield kind, f"({ast.unparse(node.operand)})"
    elif isinstance(node, ast.Call):
        yield from _of_call(node)
    elif isinstance(node, ast.Attribute) and node.attr == "T":
        yield "call dropped", ast.unparse(node.value)
    elif isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Tuple):
        parts = node.slice.elts
        if len(parts) > 1 and ast.dump(parts[0]) != ast.dump(parts[1]):
            swapped = ast.Tuple([parts[1], parts[0], *parts[2:]], node.slice.ctx)
            yield "indices swapped", _with(node, slice=swapped).removeprefix("(").removesuffix(")")
    elif isinstance(node, ast.AugAssign):
        yield "deleted", "pass"
        if type(node.op) in ARITHMETIC:
            yield "arithmetic", _with(node, op=ARITHMETIC[type(node.op)]())[1:-1]
    elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        yield "deleted", "pass"
    elif isinstance(node, ast.Return) and node.value is not None:
        if returns == "bool":
            yield "negated", f"return not ({ast.unparse(node.value)})"
        elif returns in NUMBERS:
            yield "negated", f"return -({ast.unparse(node.value)})"


def _of_sum(node: ast.BinOp) -> Iterator[tuple[str, str]]:
    if _is_text(node.left) or _is_text(node.right):
        return
    if type(node.op) in ARITHMETIC:
        yield "arithmetic", _with(node, op=ARITHMETIC[type(node.op)]())
    if isinstance(node.op, (ast.Add, ast.Sub)):
        yield "term dropped", f"({ast.unparse(node.left)})"
        sign = "-" if isinstance(node.op, ast.Sub) else ""
        yield "term dropped", f"({sign}({ast.unparse(node.right)}))"
    if isinstance(node.op, (ast.Mult, ast.Div)):
        yield "factor dropped", f"({ast.unparse(node.left)})"
    if isinstance(node.op, ast.MatMult):
        yield "arguments swapped", _with(node, left=node.right, right=node.left)


def _of_constant(value: object) -> Iterator[tuple[str, str]]:
    if isinstance(value, bool):
        yield "constant", str(not value)
    elif isinstance(value, int):
        yield "constant", str(value + 1)
        yield "constant", f"({value - 1})"
    elif isinstance(value, float) and value:
        yield "constant", repr(2 * value)
        yield "constant", f"(-{value!r})"


def _of_call(node: ast.Call) -> Iterator[tuple[str, str]]:
    name = ast.unparse(node.func).rpartition(".")[2]
    if name == "einsum" and isinstance(node.args[0], ast.Constant):
        yield from _of_einsum(node)
    elif (
        name in DROPPED
        and node.args
        and not isinstance(node.args[0], (ast.Starred, ast.GeneratorExp))
    ):
        yield "call dropped", f"({ast.unparse(node.args[0])})"
    elif name in DROPPED and not node.args and isinstance(node.func, ast.Attribute):
        yield "call dropped", f"({ast.unparse(node.func.value)})"
    plain = len(node.args) > 1 and not any(isinstance(a, ast.Starred) for a in node.args[:2])
    if plain and name not in SYMMETRIC | {"einsum"} and name[0].islower():
        first, second = node.args[:2]
        if ast.dump(first) != ast.dump(second) and not (_is_text(first) or _is_text(second)):
            yield "arguments swapped", _with(node, args=[second, first, *node.args[2:]])[1:-1]


def _of_einsum(node: ast.Call) -> Iterator[tuple[str, str]]:
    text = str(node.args[0].value)  # type: ignore[attr-defined]
    taken, _, given = text.partition("->")
    parts = [part.strip("., ") for part in (given, *taken.split(","))]
    for part in parts:
        if len(part) > 1 and part in text:
            at = text.rindex(part)
            other = text[:at] + part[1] + part[0] + part[2:] + text[at + len(part) :]
            new = [ast.Constant(other), *node.args[1:]]
            yield "indices swapped", _with(node, args=new)[1:-1]


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.JoinedStr) or (
        isinstance(node, ast.Constant) and isinstance(node.value, (str, bytes))
    )


def _with(node: ast.AST, **fields: object) -> str:
    """Source of a node with some of its fields changed, in brackets."""
    values = {name: getattr(node, name) for name in node._fields} | fields
    return f"({ast.unparse(type(node)(**values))})"
