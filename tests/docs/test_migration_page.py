"""The page for programs written for ros_base says what is so."""

import ast
import difflib
import importlib
import re
from pathlib import Path

import pytest

import rosbase

TESTS = Path(__file__).parents[1]
PAGE = (TESTS.parent / "docs/migrating-from-ros_base.md").read_text()
GROUPS = [
    *("Registration", "Free names", "Handshake", "Tick", "State"),
    *("Logger", "Children", "Shutdown", "Architecture"),
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
    old, new = re.findall(r"```python\n(.*?)```", PAGE, re.S)[:2]
    changes = [
        line[2:]
        for line in difflib.ndiff(old.splitlines(), new.splitlines())
        if line.startswith(("- ", "+ "))
    ]
    assert [line for line in changes if not line.startswith(("import ", "from "))] == [
        "rclpy.init()"
    ]


# The utilities of ros_base, as its pages have them.
OLD_NAMES = {
    *("BaseManager", "BaseNode", "BaseAgent", "BaseHandlers", "BaseLauncher"),
    *("register_multiprocess_nodes", "shutdown_multiprocess_nodes"),
    *("CustomLogger", "profile_latency", "CircularBuffer", "VectorLPFilter", "warp2pi"),
    *("quat_to_rpy", "rpy_to_quat", "quat_rotate_inverse", "add_debug_mode"),
    *("trans_ros_frame_to_opt_frame", "trans_opt_to_ros_frame"),
}


def imports() -> list[list[str]]:
    section = PAGE.split("\n## Other imports\n")[1].split("\n```")[0]
    lines = [line.strip("| ").split(" | ") for line in section.splitlines() if line[:2] == "| "]
    return lines[1:]


def test_every_old_import_has_a_row_with_what_replaces_it() -> None:
    named = {name for row in imports() for name in re.findall(r"`(\w+)`", row[0])}
    assert named - {"ros_base"} == OLD_NAMES
    assert all(len(row) == 3 and row[2] for row in imports())


def test_what_is_marked_as_not_yet_there_is_not_and_the_rest_is() -> None:
    for old, new, _ in imports():
        names = set(re.findall(r"`(\w+)`", old)) - {"ros_base"}
        if new == "not yet":
            assert not names & set(rosbase.__all__), f"{names} exist: say what they are now"
        else:
            home = new.strip("`")
            module = rosbase if home in rosbase.__all__ else importlib.import_module(home)
            assert home in rosbase.__all__ or all(hasattr(module, name) for name in names)


def test_every_difference_gives_its_reason() -> None:
    section = PAGE.split("\n## Differences\n")[1].split("\n## ")[0]
    differences = [line.strip("| ").split(" | ") for line in section.splitlines() if "|" in line]
    assert len(differences) > 10
    for difference in differences[2:]:
        assert len(difference) == 3, difference
        assert all(difference), difference
