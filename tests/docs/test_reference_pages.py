"""The reference of the command line and of the environment leaves nothing out."""

import argparse
import re
from pathlib import Path

import pytest

from rosbase.cli.operate.entries import Command
from rosbase.cli.operate.words import GROUPS, HELP, PROGRAM, all_options
from rosbase.plugins import installed_plugins

ROOT = Path(__file__).parents[2]
COMMANDS = (ROOT / "docs/reference/command-line.md").read_text()
ENVIRONMENT = (ROOT / "docs/reference/environment.md").read_text()
# Most commands of other distributions are documented by these.
THEIRS = {"view"}
OURS = {
    name: command
    for name, command in installed_plugins().commands.items()
    if installed_plugins().owner_of(command).candidate.is_core
}
CHECKED = OURS | {
    name: command for name, command in installed_plugins().commands.items() if name in THEIRS
}


def named_in_tables(page: str) -> set[str]:
    """What stands in backquotes in the first cells of the page's tables."""
    cells = [line.split("|")[1] for line in page.splitlines() if line.startswith("| `")]
    return {name for cell in cells for name in re.findall(r"`([^`]+)`", cell)}


def test_every_command_has_its_section_and_no_other_has_one() -> None:
    assert set(re.findall(r"^## rosbase (\S+)$", COMMANDS, re.M)) == set(OURS) | THEIRS


@pytest.mark.parametrize("name", sorted(CHECKED.keys() - GROUPS.keys()))
def test_every_option_of_a_command_stands_in_its_table_and_no_other_does(name: str) -> None:
    parser = argparse.ArgumentParser(add_help=False)
    CHECKED[name].configure(parser)
    options = {option for action in parser._actions for option in action.option_strings}
    names = [action.dest for action in parser._actions if not action.option_strings]
    expected = {"run": ["target", "arguments"], "up": ["config"], "view": ["name"]}
    assert names == expected.get(name, [])
    section = COMMANDS.split(f"\n## rosbase {name}\n")[1].split("\n## ")[0]
    # A single `-` is a key.
    cells = named_in_tables(section) - {"-"}
    documented = {cell.split()[0] for cell in cells if cell.startswith("-")}
    assert documented == options


@pytest.mark.parametrize("name", sorted(GROUPS))
def test_every_command_for_running_programs_stands_in_its_tables_with_its_options(
    name: str,
) -> None:
    entry = GROUPS[name]
    commands = {"": entry} if isinstance(entry, Command) else entry.commands
    section = COMMANDS.split(f"\n## rosbase {name}\n")[1].split("\n## ")[0]
    cells = named_in_tables(section.replace("\\|", "|"))
    for word, command in commands.items():
        arguments = " ".join(argument.shown for argument in command.arguments)
        assert " ".join(f"rosbase {name} {word} {arguments}".split()) in cells
    flags = {
        flag
        for command in commands.values()
        for option in all_options(command)
        if option not in (HELP, PROGRAM)
        for flag in option.flags
    }
    assert {cell.split()[0] for cell in cells if cell.startswith("-")} == flags


def test_every_check_of_ours_stands_in_the_table_of_the_doctor() -> None:
    table = COMMANDS.split("| check | of |")[1]
    for name, check in installed_plugins().checks.items():
        owner = installed_plugins().owner_of(check).distribution
        assert f"| `{name}` | {owner} |" in table


def variables_in(pattern: str, *packages: str) -> set[str]:
    sources = [file for name in packages for file in (ROOT / "packages" / name).glob("src/**/*.py")]
    return {name for file in sources for name in re.findall(pattern, file.read_text())}


def test_every_variable_of_the_environment_that_is_read_stands_in_the_reference() -> None:
    own = variables_in(r"\bROSBASE_[A-Z_]+\b", *(p.name for p in (ROOT / "packages").iterdir()))
    of_ros = variables_in(r"\"((?:ROS|RMW|AMENT|FASTDDS|FASTRTPS)_[A-Z_]+)\"", "rosbase-ros2")
    assert own
    assert of_ros
    assert named_in_tables(ENVIRONMENT) == own | of_ros
