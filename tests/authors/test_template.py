"""The page `first-transport`: each unfinished step is named, and the last one works."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from copier import run_copy

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/plugins/first-transport.md").read_text()
FILES = dict(re.findall(r"```python title=(\S+)\n(.*?)```", PAGE, re.S))
STEPS = ["simulator.py", "config.py", "link.py", "test_contract.py"]


class Author:
    """Somebody who has rendered the template, and follows the page."""

    def __init__(self, folder: Path) -> None:
        self.project = folder / "imu-tcp"
        run_copy(
            str(ROOT / "docs/template"), self.project, {"name": "tcp"}, defaults=True, quiet=True
        )
        pip = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation"]
        self.site = folder / "site"
        subprocess.run(
            [*pip, "--target", str(self.site), "-e", str(self.project)], check=True, timeout=50
        )

    def write(self, name: str) -> None:
        folder = "tests" if name.startswith("test_") else "src/imu_tcp"
        assert (self.project / folder / name).exists(), "the template has no such file"
        (self.project / folder / name).write_text(FILES[name])

    def unwrite(self, name: str, method: str) -> str:
        """Takes one method back to what the template has of it; gives what that says to do."""
        file = self.project / "src/imu_tcp" / name
        template = (ROOT / "docs/template/project/src/{{ package }}" / f"{name}.jinja").read_text()
        raises = r"raise NotImplementedError\(\"(.+?)\"\)"
        found = re.search(rf"def {method}\(.*?{raises}", template, re.S)
        assert found, method
        tree = ast.parse(file.read_text())
        (node,) = (
            node
            for node in ast.walk(tree)
            if isinstance(node, ast.FunctionDef) and node.name == method
        )
        node.body = ast.parse(f"raise NotImplementedError({found[1]!r})").body
        file.write_text(ast.unparse(tree))
        return found[1]

    def run(self, *command: str) -> "subprocess.CompletedProcess[str]":
        given = filter(None, [os.environ.get("PYTHONPATH")])
        path = os.pathsep.join([str(self.site), str(self.project / "src"), *given])
        return subprocess.run(
            [sys.executable, "-W", "error", "-m", *command],
            check=False,
            capture_output=True,
            text=True,
            timeout=50,
            cwd=self.project,
            env={**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"},
        )

    def test(self) -> "subprocess.CompletedProcess[str]":
        return self.run("pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-rN")


@pytest.fixture
def author(tmp_path: Path) -> Author:
    return Author(tmp_path)


def test_the_page_gives_every_file_that_is_unfinished() -> None:
    assert list(FILES) == STEPS
    unfinished = (ROOT / "docs/template/project").rglob("*.jinja")
    names = {path.name.removesuffix(".jinja") for path in unfinished if "tep " in path.read_text()}
    assert names == set(STEPS)


@pytest.mark.parametrize("name", ["serial", "Two", "two words", "größe"])
def test_a_name_that_cannot_be_a_transports_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match=r"one lower-case word|there is one of that name"):
        run_copy(
            str(ROOT / "docs/template"), tmp_path / "x", {"name": name}, defaults=True, quiet=True
        )


NO_DEVICE = "step 1: play the device, in simulator.py"


@pytest.mark.parametrize(
    ("written", "missing"),
    [
        ([], NO_DEVICE),
        (["config.py", "link.py"], NO_DEVICE),
        (["simulator.py"], "step 2: say where the device is, in config.py"),
        (["simulator.py", "config.py"], "step 3: open the device, in link.py"),
        (["simulator.py", "config.py", "link.py"], "TransportCapabilities(is_stream=True) is not"),
    ],
)
def test_an_unfinished_step_is_named_with_its_promise_and_page(
    author: Author, written: list[str], missing: str
) -> None:
    for name in written:
        author.write(name)
    for failure in failures_of(author):
        assert missing in failure


# Whoever comes upon them first is told; other checks need none of them.
@pytest.mark.parametrize(
    ("name", "method"),
    [("link.py", "fileno"), ("link.py", "close"), ("simulator.py", "send")],
)
def test_a_single_call_that_is_not_written_yet_is_named_and_soon(
    author: Author, name: str, method: str
) -> None:
    for file in STEPS:
        author.write(file)
    step = author.unwrite(name, method)
    failures = failures_of(author)
    assert sum(step in failure for failure in failures) > len(failures) / 2


def failures_of(author: Author) -> list[str]:
    """What the tests of the author's say; each failure names a promise and the page."""
    result = author.test()
    assert result.returncode == 1, result.stdout + result.stderr
    failures = re.split(r"\n_{3,} TestContract\.\w+ _{3,}\n", result.stdout)[1:]
    assert failures
    for failure in failures:
        assert failure.startswith("broken promise: "), failure
        assert "\n  more:     docs/plugins/transport-contract.md#" in failure
    return failures


def test_the_demo_of_an_unfinished_transport_is_one_line_that_names_the_step(
    author: Author,
) -> None:
    demo = author.run("rosbase", "demo", "--transport", "tcp")
    assert demo.returncode == 2
    assert demo.stderr == f"rosbase: transport 'tcp' is not finished: {NO_DEVICE}\n"


def test_the_finished_transport_keeps_its_promises_and_runs_the_demo(author: Author) -> None:
    for name in STEPS:
        author.write(name)
    result = author.test()
    assert result.returncode == 0, result.stdout + result.stderr
    demo = author.run("rosbase", "demo", "--transport", "tcp", "--duration", "2")
    assert demo.returncode == 0, demo.stderr
    numbers = dict(line.split(" ", 1) for line in demo.stdout.splitlines() if " " in line.strip())
    assert int(numbers["published"]) >= 190
    assert numbers["lost"] == "0"
