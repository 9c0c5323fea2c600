"""Checks that type checkers find the mistakes in the programs of `typing_failures`.

There, a comment `# fails: why` ends each line with a mistake. `mypy --strict` and pyright, as it is
without settings, must each report an error on exactly these lines.
"""

import json
import re
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).parents[1]
PROGRAMS = ROOT / "tests/typing_failures"
MARK = re.compile(r"  # fails: \w")


class Line(NamedTuple):
    """A line of a program."""

    file: str
    number: int


def main() -> int:
    """Compare the lines; print each difference, and return the exit status."""
    marked = marked_lines()
    differences = [
        *compare("mypy", marked, run_mypy()),
        *compare("pyright", marked, run_pyright()),
    ]
    print(*differences, f"{len(marked)} mistakes, {len(differences)} differences", sep="\n")
    return 1 if differences or not marked else 0


def marked_lines() -> set[Line]:
    """Return the lines that end with the comment."""
    return {
        Line(program.name, number)
        for program in PROGRAMS.glob("*.py")
        for number, text in enumerate(program.read_text().splitlines(), start=1)
        if MARK.search(text)
    }


def compare(checker: str, marked: set[Line], reported: dict[Line, str]) -> Iterable[str]:
    """Yield a text for each line that is marked and not reported, or reported and not marked."""
    for file, number in sorted(marked - reported.keys()):
        yield f"{checker} reports nothing in {file}:{number}"
    for line in sorted(reported.keys() - marked):
        yield f"{checker} reports in {line.file}:{line.number}: {reported[line]}"


def run_mypy() -> dict[Line, str]:
    """Return what mypy reports, by line."""
    config = ["--config-file", str(ROOT / "pyproject.toml"), "--strict", "--output", "json"]
    found = [json.loads(line) for line in run("mypy", *config, str(PROGRAMS)).splitlines()]
    return {
        Line(Path(each["file"]).name, each["line"]): each["message"]
        for each in found
        if each["severity"] == "error"
    }


def run_pyright() -> dict[Line, str]:
    """Return what pyright reports, by line; it counts lines from 0."""
    options = ["--outputjson", "--pythonpath", sys.executable]
    found: Any = json.loads(run("pyright", *options, str(PROGRAMS)))
    return {
        Line(Path(each["file"]).name, each["range"]["start"]["line"] + 1): each["message"]
        for each in found["generalDiagnostics"]
        if each["severity"] == "error"
    }


def run(module: str, *arguments: str) -> str:
    """Run a checker, which ends with status 1 if it reports anything; return what it prints."""
    command = [sys.executable, "-m", module, *arguments]
    result = subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True)
    if result.returncode > 1:
        raise RuntimeError(f"{module} failed: {result.stdout}{result.stderr}")
    return result.stdout


if __name__ == "__main__":
    sys.exit(main())
