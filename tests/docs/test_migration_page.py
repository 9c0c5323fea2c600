"""The page for programs written for ros_base says what is so."""

import ast
import difflib
import re
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
PAGE = (TESTS.parent / "docs/migrating-from-ros_base.md").read_text()
GROUPS = [
    *("Registration", "Names left free", "Handshake", "Tick", "State"),
    *("Logger", "Children", "End", "Architecture"),
]


def rows(group: str) -> list[list[str]]:
    """The rows of the table under that heading."""
    section = PAGE.split(f"\n### {group}\n")[1].split("\n#")[0]
    lines = [line for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def names_in(file: Path) -> set[str]:
    return {
        node.name
        for node in ast.parse(file.read_text()).body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    }


@pytest.mark.parametrize("group", GROUPS)
def test_every_promise_names_a_test_that_exists(group: str) -> None:
    assert rows(group)
    for promise, test in rows(group):
        found = re.fullmatch(r"`([\w/]+\.py)::(test_\w+)`", test)
        assert found, f"{promise}: {test} is not a test"
        assert found[2] in names_in(TESTS / found[1]), f"{promise}: there is no {test}"


def test_no_group_of_promises_is_left_out() -> None:
    assert re.findall(r"^### (.+)$", PAGE, re.M) == GROUPS


def test_the_two_programs_differ_in_imports_and_initialisation_only() -> None:
    old, new = re.findall(r"```python\n(.*?)```", PAGE, re.S)
    changes = [
        line[2:]
        for line in difflib.ndiff(old.splitlines(), new.splitlines())
        if line.startswith(("- ", "+ "))
    ]
    assert [line for line in changes if not line.startswith(("import ", "from "))] == [
        "rclpy.init()"
    ]


def test_every_difference_gives_its_reason() -> None:
    section = PAGE.split("\n## What is different, and why\n")[1].split("\n## ")[0]
    differences = [line.strip("| ").split(" | ") for line in section.splitlines() if "|" in line]
    assert len(differences) > 10
    for difference in differences[2:]:
        assert len(difference) == 3, difference
        assert all(difference), difference
