"""The rules of docs/design.md that no tool checks."""

import ast
import io
import re
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

# A backend has more to it than a transport: messages, services, parameters, time, logs. And over
# MQTT there is a connection to be reached and kept, packets of a broker that nobody trusts, and a
# WebSocket that may carry them. Both have a check for `rosbase doctor`, and that of ROS asks a
# process of its own, which ROS may end. What ROS, its middleware and its tools leave unsaid has
# modules of its own: how it starts, what the machine must offer, what users set from outside,
# messages that are refused, questions for the main loop, parameters as they are written, a
# program's own rclpy, and the turns of its tasks; services, with their two ends, their messages,
# answers that are dropped, and a watch; the end of a process that hangs; taps, the graph, and
# formats of messages, for those who look at a program; the ends, parameters and lifecycle of one
# that is recorded. The nodes of one process, each a node of ROS, share a context. A serial port has
# surroundings, each a subject of its own: the driver, other programs and who they are, two kinds of
# network, and the speed of a UART. A view has a model, drawings, a page for each subject, a source
# and widgets; a server for other viewers brings each subject to them, and a recording is played.
# A recording is a format of its own: its records, chunks and end, each with a writer and a reader,
# a scan that trusts nothing, and the mending of files that were cut off. Messages come from within
# a program or through its control socket, wait for a thread, and go into files or a ring. A replay
# has its own: bags of others, the files of a run, inputs, outputs, differences and their report.
# Each command has a module.
MOST_MODULES = {
    "imu-mqtt": 14,
    "imu-serial": 13,
    "rosbase-mcap": 60,
    "rosbase-ros2": 52,
    "rosbase-view": 85,
}
PLUGINS = [folder for folder in (ROOT / "packages").iterdir() if folder.name != "rosbase-core"]


def modules_of(package: Path) -> list[Path]:
    return sorted(package.glob("src/**/*.py"))


@pytest.mark.parametrize("package", PLUGINS, ids=lambda folder: folder.name)
def test_a_plugin_uses_no_underscore_name_of_the_core(package: Path) -> None:
    for module in modules_of(package):
        for node in ast.walk(ast.parse(module.read_text())):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("rosbase"):
                names = [*(node.module or "").split("."), *(alias.name for alias in node.names)]
                assert not [name for name in names if name.startswith("_")], module


@pytest.mark.parametrize("package", PLUGINS, ids=lambda folder: folder.name)
def test_a_transport_has_at_most_seven_modules(package: Path) -> None:
    named = [module for module in modules_of(package) if module.name != "__init__.py"]
    assert len(named) <= MOST_MODULES.get(package.name, 7)


def test_nothing_but_the_clock_reads_the_time() -> None:
    # The guardian of a child is a script that starts without any of our modules. Commands that ask
    # a running program are over in less time than the clock takes to import.
    readers = {"clock.py", "guardian.py", "time_limit.py"}
    for module in [m for p in (ROOT / "packages").iterdir() for m in modules_of(p)]:
        for node in ast.walk(ast.parse(module.read_text())):
            if isinstance(node, ast.Import) and module.name not in readers:
                assert "time" not in [alias.name for alias in node.names], module


def test_every_exception_from_the_checks_has_a_reason() -> None:
    exception = re.compile(r"# (noqa: [A-Z0-9, ]+|type: ignore\[[a-z, -]+\])")
    # Of two in one line, the last has it.
    with_reason = re.compile(
        f"({exception.pattern}  )*{exception.pattern}(  # | - )(?!noqa|type:).+"
    )
    # They have mistakes on purpose, and say which.
    exempt = ROOT / "tests" / "typing_failures"
    lines = [
        f"{file.relative_to(ROOT)}: {token.line.strip()}"
        for folder in ("packages", "tests", "docs", "tools")
        for file in sorted((ROOT / folder).rglob("*.py"))
        if exempt not in file.parents
        for token in tokenize.generate_tokens(io.StringIO(file.read_text()).readline)
        if token.type == tokenize.COMMENT
        and exception.match(token.string)
        and not with_reason.match(token.string)
    ]
    assert lines == []
