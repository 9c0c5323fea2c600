"""Every code block of the documentation runs, or says why it does not."""

from pathlib import Path

import pytest

from rosbase.cli.arguments import check_given, read_given
from rosbase.imu.settings import read_settings, reader_parameters
from rosbase.plugins import installed_plugins
from rosbase.text.toml import parse_toml
from support.code_blocks import BLOCKS, ROOT
from support.code_runs import run_commands, run_python


def of_kind(kind: str) -> list[str]:
    return [name for name, block in BLOCKS.items() if block.kind == kind and block.is_run_here]


def test_every_block_is_of_a_kind_that_is_checked() -> None:
    # Diagrams are checked by tests/integration/test_examples.py, units for systemd and parameters
    # for nav2 by tests/ros2/test_documentation.py, payloads in JSON by test_mapping_page.py.
    kinds = {"bash", "ini", "json", "mermaid", "python", "text", "toml", "yaml"}
    assert {block.kind for block in BLOCKS.values()} <= kinds
    assert len(BLOCKS) >= 40


def test_what_is_said_above_a_block_is_understood() -> None:
    known = (
        "not run: ", "on ROS 2", "device", "ends with status 1", "logs errors", "prints", "payload",
        "gives",
    )  # fmt: skip
    assert all(b.says.startswith(known) for b in BLOCKS.values() if b.says)


def test_files_of_the_template_are_where_tests_authors_looks_for_them() -> None:
    pages = {block.page.relative_to(ROOT).as_posix() for block in BLOCKS.values() if block.title}
    assert pages <= {"docs/plugins/first-transport.md"}


@pytest.mark.parametrize("name", of_kind("python"))
def test_python_runs(name: str, tmp_path: Path) -> None:
    run_python(BLOCKS[name], tmp_path)


@pytest.mark.parametrize("name", of_kind("bash"))
def test_commands_run(name: str, tmp_path: Path) -> None:
    run_commands(BLOCKS[name], tmp_path)


# The entry point on the page of hooks is checked by test_hooks_page.py.
@pytest.mark.parametrize("name", [n for n in of_kind("toml") if "[project" not in BLOCKS[n].text])
def test_parameter_files_describe_a_reader(name: str, tmp_path: Path) -> None:
    file = tmp_path / "imu.toml"
    file.write_text(BLOCKS[name].text)
    assert parse_toml(file.read_text())
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
