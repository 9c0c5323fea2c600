"""Nothing below the commands depends on the order of a set.

It changes with the hash seed, and with addresses of objects in memory, so a program would not run
the same way twice, and a recording of it would not replay.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import rosbase

ROOT = Path(rosbase.__file__).parent
# What runs between the ticks of a program. The commands above are processes of their own.
FLOORS = (
    "contracts",
    "control",
    "device",
    "entries",
    "framing",
    "fsm",
    "lifecycle",
    "local",
    "logger",
    "manager",
    "mapping",
    "messages",
    "parameters",
    "plugins",
    "processes",
    "roles",
    "runtime",
    "stamps",
    "text",
    "wire",
)
# These take a set in any order, and give the same.
ORDERLESS = {"all", "any", "frozenset", "len", "max", "min", "set", "sorted", "sum"}
# These keep the order.
ORDERED = {"deque", "enumerate", "iter", "list", "map", "tuple", "zip"}
SETS = {"AbstractSet", "MutableSet", "WeakSet", "frozenset", "set"}
ALLOWED = {
    "control/questions/base.py: pids.pop()": "it has one item",
    "entries/recorder.py: _recorders": "each only forgets, in a forked child",
    "mapping/clashes.py: waiting.pop()": "the answer is whether there is one, in any order",
    "mapping/quantities.py: parents.pop()": "it has one item",
    "mapping/quick_dates.py: parents.pop()": "it has one item",
    "parameters/kinds.py: types.pop()": "it has one item",
    "processes/adoption.py: dead": "processes that have ended",
    "processes/guardian.py: _stops()": "the guardian is a process of its own",
    "processes/guardian.py: set(os.read(fd, 512)) & _stops()": "likewise",
    "processes/registration.py: _running": "at the end of the process",
}
"""Places that take a set in its order, and why that changes nothing."""


def test_nothing_iterates_a_set() -> None:
    found = set()
    for path in _modules():
        tree = ast.parse(path.read_text())
        finder = _Finder(tree, set(_attributes(tree)), set(_functions(tree)))
        found |= {f"{path.relative_to(ROOT)}: {ast.unparse(node)}" for node in finder.found}
    assert sorted(found) == sorted(ALLOWED)


def test_the_search_finds_what_it_looks_for() -> None:
    tree = ast.parse(
        "one: set[int] = set()\n"
        "for _ in one: pass\n"
        "[x for x in {1, 2} | one]\n"
        "list(one)\n"
        "one.pop()\n"
        "(*one,)\n"
        "', '.join(one)\n"
        "sorted(x for x in one)\n"
    )
    assert len(_Finder(tree, set(), set()).found) == 6


def _modules() -> Iterator[Path]:
    yield ROOT / "clock.py"
    yield ROOT / "qos.py"
    for floor in FLOORS:
        yield from (ROOT / floor).rglob("*.py")


def _is_set_type(annotation: ast.expr | None) -> bool:
    if isinstance(annotation, ast.Constant) and isinstance(annotation.value, str):
        annotation = ast.parse(annotation.value, mode="eval").body
    if isinstance(annotation, ast.Subscript):
        annotation = annotation.value
    name = annotation.attr if isinstance(annotation, ast.Attribute) else annotation
    return (name.id if isinstance(name, ast.Name) else name) in SETS


def _attributes(tree: ast.Module) -> Iterator[str]:
    """Yield the names of attributes that are sets, of `self` and in bodies of classes."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            for line in node.body:
                if isinstance(line, ast.AnnAssign) and _is_set_type(line.annotation):
                    yield ast.unparse(line.target)
        elif isinstance(node, ast.AnnAssign):
            if isinstance(node.target, ast.Attribute) and _is_set_type(node.annotation):
                yield node.target.attr
        elif isinstance(node, ast.Assign):
            target, nothing = node.targets[0], _Finder(ast.Module([], []), set(), set())
            if isinstance(target, ast.Attribute) and nothing.is_set(node.value):
                yield target.attr


def _functions(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and _is_set_type(node.returns):
            yield node.name


class _Finder(ast.NodeVisitor):
    """Collects the places that take the items of a set in its order."""

    def __init__(self, tree: ast.Module, attributes: set[str], functions: set[str]) -> None:
        self.found: list[ast.AST] = []
        self._attributes = attributes
        self._functions = functions
        self._names: set[str] = set()
        self._orderless: set[ast.AST] = set()
        self.visit(tree)

    def is_set(self, node: ast.expr) -> bool:
        """Return whether an expression is known to be a set."""
        if isinstance(node, (ast.Set, ast.SetComp)):
            return True
        if isinstance(node, ast.BinOp):
            is_joined = isinstance(node.op, (ast.BitOr, ast.BitAnd, ast.BitXor, ast.Sub))
            return is_joined and (self.is_set(node.left) or _is_keys(node.left))
        if isinstance(node, ast.Name):
            return node.id in self._names
        if isinstance(node, ast.Attribute):
            return node.attr in self._attributes
        if isinstance(node, ast.NamedExpr):
            return self.is_set(node.value)
        if isinstance(node, ast.IfExp):
            return self.is_set(node.body) or self.is_set(node.orelse)
        if isinstance(node, ast.Call):
            name = node.func
            if isinstance(name, ast.Name):
                return name.id in SETS or name.id in self._functions
            if isinstance(name, ast.Attribute):
                is_ours = name.attr in self._functions
                joins = ("union", "difference", "intersection", "symmetric_difference", "copy")
                return is_ours or (name.attr in joins and self.is_set(name.value))
        return False

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        known = set(self._names)
        for argument in [*node.args.args, *node.args.kwonlyargs]:
            if _is_set_type(argument.annotation):
                self._names.add(argument.arg)
            else:
                self._names.discard(argument.arg)
        self.generic_visit(node)
        self._names = known

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if isinstance(node.target, ast.Name) and _is_set_type(node.annotation):
            self._names.add(node.target.id)
        self.generic_visit(node)

    def visit_Assign(self, node: ast.Assign) -> None:
        self.generic_visit(node)
        target, values = node.targets[0], [node.value]
        targets = target.elts if isinstance(target, ast.Tuple) else [target]
        if isinstance(node.value, ast.Tuple):
            values = node.value.elts
        for one, value in zip(targets, values, strict=False):
            if isinstance(one, ast.Name):
                (self._names.add if self.is_set(value) else self._names.discard)(one.id)
            if isinstance(one, (ast.Tuple, ast.List)) and self.is_set(value):
                self.found.append(node)
        if len(targets) > 1 and self.is_set(node.value):
            self.found.append(node)

    def visit_NamedExpr(self, node: ast.NamedExpr) -> None:
        self.generic_visit(node)
        if self.is_set(node.value):
            self._names.add(node.target.id)

    def visit_For(self, node: ast.For) -> None:
        self._look_at(node.iter)
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        name = node.func
        if isinstance(name, ast.Name) and name.id in ORDERLESS:
            self._orderless |= {one for one in node.args if isinstance(one, ast.GeneratorExp)}
        elif isinstance(name, ast.Name) and name.id in ORDERED:
            for argument in node.args:
                self._look_at(argument)
        elif isinstance(name, ast.Attribute):
            if name.attr == "pop" and not node.args and self.is_set(name.value):
                self.found.append(node)
            if name.attr in ("extend", "join", "fromkeys"):
                for argument in node.args:
                    self._look_at(argument)
        self.generic_visit(node)

    def visit_Starred(self, node: ast.Starred) -> None:
        self._look_at(node.value)
        self.generic_visit(node)

    def visit_ListComp(self, node: ast.ListComp) -> None:
        self._look_at(node.generators[0].iter)
        self.generic_visit(node)

    def visit_DictComp(self, node: ast.DictComp) -> None:
        self._look_at(node.generators[0].iter)
        self.generic_visit(node)

    def visit_GeneratorExp(self, node: ast.GeneratorExp) -> None:
        if node not in self._orderless:
            self._look_at(node.generators[0].iter)
        self.generic_visit(node)

    def _look_at(self, node: ast.expr) -> None:
        if self.is_set(node):
            self.found.append(node)


def _is_keys(node: ast.expr) -> bool:
    return (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and node.func.attr in ("keys", "items")
    )
