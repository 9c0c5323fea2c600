"""Every code block of the documentation runs, or says why it does not."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import NamedTuple

import pytest

from rosbase.cli.arguments import check_given, read_given
from rosbase.imu.settings import read_settings, reader_parameters
from rosbase.plugins import installed_plugins

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    [
        *ROOT.glob("*.md"),
        *ROOT.glob("docs/*.md"),
        *ROOT.glob("docs/reference/*.md"),
        *ROOT.glob("docs/examples/*/*.md"),
        *ROOT.glob("packages/*/*.md"),
        ROOT / "tests/README.md",
    ]
)
BLOCK = re.compile(
    r"(?:<!-- not run: (?P<reason>.+?) -->\n)?```(?P<kind>\w*)\n(?P<text>.*?)```", re.S
)


class Block(NamedTuple):
    """A fenced block of a page."""

    kind: str
    text: str
    reason: str


BLOCKS = {
    f"{page.relative_to(ROOT)}:{number}": Block(m["kind"], m["text"], m["reason"] or "")
    for page in PAGES
    for number, m in enumerate(BLOCK.finditer(page.read_text()), start=1)
}


def of_kind(kind: str) -> list[str]:
    return [name for name, block in BLOCKS.items() if block.kind == kind and not block.reason]


def test_every_block_is_of_a_kind_that_is_checked() -> None:
    # The diagrams are checked by tests/integration/test_examples.py.
    kinds = {"bash", "mermaid", "python", "text", "toml"}
    assert {block.kind for block in BLOCKS.values()} <= kinds
    assert len(BLOCKS) >= 8


@pytest.mark.parametrize("name", of_kind("python"))
def test_python_runs(name: str) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", BLOCKS[name].text],
        capture_output=True,
        text=True,
        timeout=50,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout


@pytest.mark.parametrize("name", of_kind("bash"))
def test_commands_run(name: str) -> None:
    # What is installed is installed already, and this test must not run all tests.
    commands = [
        part.strip()
        for line in BLOCKS[name].text.splitlines()
        for part in line.split("&&")
        if not part.strip().startswith("pip install") and part.strip() != "nox"
    ]
    bin_folder = str(Path(sys.executable).parent)
    for command in commands:
        done = subprocess.run(
            command,
            shell=True,
            cwd=ROOT,
            env={**os.environ, "PATH": f"{bin_folder}:{os.environ['PATH']}"},
            capture_output=True,
            text=True,
            timeout=50,
            check=False,
        )
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", of_kind("toml"))
def test_parameter_files_describe_a_reader(name: str, tmp_path: Path) -> None:
    file = tmp_path / "imu.toml"
    file.write_text(BLOCKS[name].text)
    assert tomllib.loads(file.read_text())
    specs = reader_parameters(installed_plugins())
    values = {spec.name: spec.default for spec in specs} | check_given(specs, read_given([], file))
    read_settings(installed_plugins(), values.__getitem__)


def test_the_mapping_page_names_every_preset_and_every_mapping_parameter() -> None:
    page = (ROOT / "docs/mapping.md").read_text()
    for preset in installed_plugins().presets:
        assert f"`{preset}`" in page
    for spec in reader_parameters(installed_plugins()):
        if spec.name.startswith("mapping."):
            assert spec.name in page or f".{spec.name.rpartition('.')[2]}`" in page, spec.name


@pytest.mark.parametrize("transport", ["serial", "mqtt"])
def test_a_transports_readme_names_every_parameter_with_its_default(transport: str) -> None:
    page = (ROOT / f"packages/imu-{transport}/README.md").read_text()
    for spec in installed_plugins().transport(transport).parameters:
        default = str(spec.default).lower() if isinstance(spec.default, bool) else str(spec.default)
        row = next(line for line in page.splitlines() if line.startswith(f"| `{spec.name}`"))
        assert default in row
