"""Every install command that a page or a message advises works as it is written.

It works in a clone alone, and the same packages can be had from an index that has our wheels.
"""

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest
from attrs import frozen

from rosbase.text.toml import parse_toml
from support.code_blocks import ROOT
from support.install_commands import (
    commands_of_pages,
    commands_of_sources,
    from_an_index,
    texts_of_sources,
)
from support.installing import OURS, Environment, build_wheels, copy_repository, serving

PAGES = commands_of_pages()
ROS = re.compile(r"rosbase-ros2|ros-jazzy")


@frozen
class Case:
    """Commands that are run one after the other in a new environment."""

    commands: tuple[str, ...]
    has_core: bool
    """Whether they stand in a message of rosbase, whose reader has the core."""

    def __str__(self) -> str:
        return " && ".join(self.commands)

    def run(self, environment: Environment, clone: Path, index: str) -> None:
        """Run them; the index is used for those that name one of our distributions."""
        if self.has_core:
            environment.run("pip install rosbase-core", clone, index)
        for command in self.commands:
            names = {word.partition("[")[0] for word in shlex.split(command)}
            environment.run(command, clone, index if names & OURS else "")
            assert OURS & {Path(name).name for name in names} <= environment.distributions()


def every_case() -> list[Case]:
    """Return each case once, however many texts advise it."""
    written = [
        *(Case(tuple(commands), has_core=False) for commands in PAGES.values()),
        *(Case((command,), has_core=True) for command in sorted(commands_of_sources())),
    ]
    # What is worked on, and a plugin of the reader's own, are not in an index.
    finished = [case for case in written if " -e " not in str(case)]
    named = [
        Case(tuple(map(from_an_index, case.commands)), case.has_core)
        for case in finished
        if "./docs/" not in str(case)
    ]
    return list(dict.fromkeys(written + named))


CASES = every_case()
SMALL = [case for case in CASES if not ROS.search(str(case))]


@pytest.fixture(scope="session")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    # Commands may write beside it.
    return copy_repository(tmp_path_factory.mktemp("home") / "rosbase")


@pytest.fixture(scope="session")
def index(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with serving(build_wheels(tmp_path_factory.mktemp("index"))) as address:
        yield address


def test_no_command_of_a_message_is_overlooked() -> None:
    texts = list(texts_of_sources())
    assert len(texts) >= 10
    found = commands_of_sources()
    for text in texts:
        advised = [part for part in re.split(r"(?=pip install)", text) if "pip install" in part]
        assert all(any(part.startswith(command) for command in found) for part in advised), text


@pytest.mark.timeout(300)
@pytest.mark.parametrize("case", SMALL, ids=str)
def test_it_installs_what_it_says(case: Case, clone: Path, index: str, tmp_path: Path) -> None:
    case.run(Environment(tmp_path / "environment"), clone, index)


@pytest.mark.timeout(300)
@pytest.mark.parametrize("command", ["./packages/rosbase-core ./packages/imu-serial", "imu-serial"])
def test_pip_itself_does_it_too(command: str, clone: Path, index: str, tmp_path: Path) -> None:
    environment = Environment(tmp_path / "environment")
    of_index = "" if "./" in command else index
    environment.run(f"pip install {command}", clone, of_index, with_pip=True)
    assert environment.distributions() == {"rosbase-core", "imu-serial"}


@pytest.mark.timeout(600)
def test_those_that_bring_ros_do_so_too(clone: Path, index: str, tmp_path: Path) -> None:
    # In one environment, because ROS takes a minute to install; without ours, each time.
    environment = Environment(tmp_path / "environment")
    for case in CASES:
        if case not in SMALL:
            environment.run(f"pip uninstall {' '.join(sorted(OURS))}", clone)
            case.run(environment, clone, index)


@pytest.mark.parametrize("place", [place for place in PAGES if "./packages/" in str(PAGES[place])])
def test_its_page_says_that_pypi_has_none_of_ours(place: str) -> None:
    page = ROOT / re.split(r"[:,]", place)[0]
    if page.name != "CONTRIBUTING.md":
        assert re.search(r"not\s+on\s+PyPI\s+yet", page.read_text())


def test_no_page_takes_ours_from_pypi() -> None:
    words = {w for commands in PAGES.values() for c in commands for w in shlex.split(c)}
    assert not {word.partition("[")[0] for word in words} & OURS


def test_the_broker_of_the_message_is_the_one_of_the_extra() -> None:
    project = parse_toml((ROOT / "packages/imu-mqtt/pyproject.toml").read_text())["project"]
    (broker,) = project["optional-dependencies"]["broker"]
    assert f"pip install '{broker}'" in commands_of_sources()


@pytest.mark.parametrize("package", ["rosbase-mcap", "rosbase-view"])
def test_the_libraries_of_the_messages_are_those_of_the_extras(package: str) -> None:
    project = parse_toml((ROOT / f"packages/{package}/pyproject.toml").read_text())["project"]
    advised = commands_of_sources()
    for (needed,) in project["optional-dependencies"].values():
        assert f"pip install '{needed}'" in advised


def test_the_template_says_what_its_page_says() -> None:
    said = (ROOT / "docs/template/copier.yml").read_text()
    rendered = said.replace("{{ _copier_conf.dst_path }}", "../imu-tcp")
    (command,) = re.findall(r"pip install -e [^,]+", rendered)
    assert any(command in commands for commands in PAGES.values())
