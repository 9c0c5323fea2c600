"""The code in docstrings does what it says."""

import ast
import inspect
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

from generators import docstrings
from rosbase import errors, fsm
from rosbase.contracts import backend
from rosbase.lifecycle import CallbackReturn, machine
from rosbase.local import LocalBackend
from rosbase.testing import TransportContract, backend_contract

PACKAGES = Path(__file__).parents[2] / "packages"
NODES = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
BAD_OPENINGS = re.compile(r"(Who|Whoever|What|That of|Those of|So many)\b")
MOST_WORDS = 30


def docstrings_of(tree: ast.AST) -> Iterator[str]:
    """Those of modules, classes and functions, and the texts below constants and attributes."""
    for node in ast.walk(tree):
        if isinstance(node, NODES):
            yield ast.get_docstring(node) or ""
            for statement, after in pairwise(node.body):
                is_named = isinstance(statement, (ast.Assign, ast.AnnAssign))
                if (
                    is_named
                    and isinstance(after, ast.Expr)
                    and isinstance(after.value, ast.Constant)
                ):
                    yield str(after.value.value)


def is_hard_to_read(docstring: str) -> bool:
    line = docstring.strip().partition("\n")[0]
    sentences = re.split(r"(?<=[.!?:;]) ", line)
    return BAD_OPENINGS.match(line) is not None or any(
        len(sentence.split()) > MOST_WORDS for sentence in sentences
    )


def code_in(docstring: str) -> str:
    """Its indented and fenced lines."""
    lines = docstring.splitlines()
    docstrings.prepare(None, "module", "", None, None, lines)
    start = lines.index("::") + 2 if "::" in lines else len(lines)
    indented = [line for line in lines[start:] if line.startswith("    ")]
    return "\n".join(line[4:] for line in indented)


def code_of(documented: object) -> str:
    return code_in(inspect.getdoc(documented) or "")


def test_every_docstring_with_code_is_tested_here() -> None:
    found = {
        file.as_posix().split("/src/")[1]
        for file in PACKAGES.glob("*/src/**/*.py")
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, NODES) and code_in(ast.get_docstring(node) or "")
    }
    assert found == {
        "rosbase/errors.py",
        "rosbase/fsm/__init__.py",
        "rosbase/lifecycle/machine.py",
        "rosbase/testing/backend_contract.py",
        "rosbase/testing/transport_contract.py",
    }


def test_the_floor_of_english_refuses_what_it_should() -> None:
    assert is_hard_to_read("What a transport is doing.")
    assert is_hard_to_read("So many usual payloads.")
    assert is_hard_to_read("Return " + "very " * 30 + "much.")
    assert not is_hard_to_read("State of a transport.")
    assert not is_hard_to_read("Return the state.\n\nWhat follows the first line is not judged.")


def test_docstrings_begin_in_plain_english() -> None:
    files = list(PACKAGES.glob("*/src/**/*.py"))
    assert len(files) > 200
    found = [
        f"{file.name}: {docstring.strip().partition(chr(10))[0]}"
        for file in files
        for docstring in docstrings_of(ast.parse(file.read_text()))
        if is_hard_to_read(docstring)
    ]
    assert found == []


def test_the_tree_of_errors_is_the_tree_of_classes() -> None:
    drawn: dict[str, str] = {}
    path: list[str] = []
    for line in code_of(errors).splitlines():
        found = re.search(r"\w+", line)
        assert found is not None
        del path[found.start() // 4 :]
        drawn[found[0]] = path[-1] if path else "Exception"
        path.append(found[0])
    bases = {name: getattr(errors, name).__base__.__name__ for name in errors.__all__}
    assert drawn == bases


def test_the_steps_of_the_lifecycle_machine_are_those_of_the_comments() -> None:
    names: dict[str, Any] = {"machine": machine.Machine(), "CallbackReturn": CallbackReturn}
    for line in code_of(machine).splitlines():
        code, _, steps = line.partition("#")
        exec(code, names)
        event = names["event"]
        assert steps.strip() == f"{event.start.label} -> {event.goal.label}"


def test_the_machine_of_the_task_goes_back_and_forth() -> None:
    class Stub:
        target: Any = None
        closed = 0

        def close(self) -> None:
            self.closed += 1

    stub = Stub()
    names: dict[str, Any] = {**vars(fsm), "tracker": stub, "gripper": stub}
    exec(code_of(fsm), names)
    task = names["machine"]
    task.step()
    assert task.state == "search"
    stub.target = "cup"
    task.step()
    assert task.state == "grasp"
    stub.target = None
    for _ in range(30):
        task.step()
    assert task.state == "search"
    assert stub.closed >= 20


def test_the_contract_is_subclassed_as_it_says() -> None:
    names: dict[str, Any] = {"TransportContract": TransportContract}
    exec(code_of(TransportContract), names)
    assert names["TestUdp"].transport == "udp"


def test_the_contract_of_backends_is_subclassed_as_it_says() -> None:
    names: dict[str, Any] = {**vars(backend), **vars(backend_contract), "MyBackend": LocalBackend}
    exec(code_of(backend_contract), names)
    check = names["TestMyBackend"]()
    check.setup_method()
    check.test_opens()
    check.teardown_method()
