"""A command for running programs starts about as quickly as Python itself."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.operated import APP, Robots, robots_in

# Modules whose import would take a good part of the time of a command.
SLOW = {
    *("argparse", "asyncio", "attr", "attrs", "collections", "dataclasses", "difflib", "enum"),
    *(
        "importlib.metadata",
        "inspect",
        "json",
        "logging",
        "pathlib",
        "pluggy",
        "re",
        "selectors",
        "shutil",
    ),
    *("signal", "socket", "subprocess", "tempfile", "threading", "typing", "yaml"),
    *("rosbase.plugins", "rosbase.messages", "rosbase.clock", "rosbase.cli.run"),
}
TELL = """
import sys
before = set(sys.modules)
from rosbase.cli import main
status = main(sys.argv[1:])
print(*sorted(set(sys.modules) - before), file=sys.stderr)
sys.exit(status)
"""


@pytest.fixture
def robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robots]:
    with robots_in(tmp_path, monkeypatch) as found:
        yield found


@pytest.mark.parametrize(
    "words",
    [
        "ps", "node list", "topic list", "service list", "param list", "param get app robot.speed",
        "lifecycle get", "lifecycle set arm configure", "log", "stats", "_complete topic ''",
        "topic --help", "stop app",
    ],
)  # fmt: skip
def test_a_command_imports_nothing_slow(robots: Robots, words: str) -> None:
    robots.start(APP)
    # Isolated from what an environment imports by itself.
    command = [sys.executable, "-c", TELL, *words.split()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=40, check=False)
    assert done.returncode == 0, done.stderr
    imported = set(done.stderr.split())
    assert "rosbase.cli.operate" in imported
    assert not imported & SLOW
    assert len([name for name in imported if name.startswith("rosbase")]) < 25
