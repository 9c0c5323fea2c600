"""The install commands that pages and messages advise, as they are written."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from support.code_blocks import BLOCKS, PAGES, ROOT

__all__ = ["commands_of_pages", "commands_of_sources", "from_an_index", "texts_of_sources"]

# Each argument is quoted, or has none of the characters that end a command in a sentence.
_COMMAND = re.compile(r"pip install(?: (?:'[^']+'|[-./\w]*[\w/]))+")
_INLINE = re.compile(r"`(pip install [^`]+)`")
# What may stand for the values in an f-string, by their names; for any other, nothing does.
_VALUES = {
    "name": ["imu-serial"],
    "package": ["imu-mqtt", "imu-serial", "rosbase-mcap", "rosbase-ros2"],
    "wheel": ["ros-jazzy-nav-msgs", "ros-jazzy-std-srvs", "ros-jazzy-visualization-msgs"],
}


def commands_of_pages() -> dict[str, list[str]]:
    """Return the commands of each block, in order, and each one in a sentence, by place.

    `copier` is among them: it makes the folder that a later command installs.
    """
    found = {}
    for name, block in BLOCKS.items():
        if block.kind == "bash" and "pip install " in block.text:
            lines = re.split(r"\n| && ", re.sub(r" +#.*", "", block.text))
            found[name] = [line for line in lines if line.startswith(("pip install ", "copier "))]
    for page in PAGES:
        for number, command in enumerate(_INLINE.findall(page.read_text()), start=1):
            found[f"{page.relative_to(ROOT).as_posix()}, in sentence {number}"] = [command]
    return found


def commands_of_sources() -> set[str]:
    """Return the commands in the texts of all distributions."""
    return {command for text in texts_of_sources() for command in _COMMAND.findall(text)}


def from_an_index(command: str) -> str:
    """Return the same command with the names of our distributions in place of their folders."""
    return command.replace("./packages/", "")


def texts_of_sources() -> Iterator[str]:
    """Yield every text of all distributions that has a command, with its values filled in."""
    for source in sorted(ROOT.glob("packages/*/src/**/*.py")):
        if "pip install" in source.read_text():
            yield from (text for text in _texts_of(source) if "pip install" in text)


def _texts_of(source: Path) -> Iterator[str]:
    nodes = list(ast.walk(ast.parse(source.read_text())))
    formatted = [node for node in nodes if isinstance(node, ast.JoinedStr)]
    parts = {part for text in formatted for part in text.values}
    for text in formatted:
        for number in range(max(map(len, _VALUES.values()))):
            yield "".join(_text_of(part, number) for part in text.values)
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in parts:
            yield node.value


def _text_of(part: ast.expr, number: int) -> str:
    if isinstance(part, ast.FormattedValue):
        values = _VALUES.get(ast.unparse(part.value), [""])
        return values[number % len(values)]
    assert isinstance(part, ast.Constant)
    return str(part.value)
