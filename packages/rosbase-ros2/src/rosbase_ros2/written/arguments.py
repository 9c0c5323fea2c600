"""The arguments for ROS on the command line, with the files that they name."""

import os
import re
import stat
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from attrs import frozen

from rosbase import Written, WrittenText
from rosbase_ros2.written.documents import (
    Sections,
    entries,
    for_rcl,
    quoted,
    read_documents,
    read_value,
    written_of,
)
from rosbase_ros2.written.guess import is_mixed

__all__ = ["RosArguments"]

_FILE = "--params-file"
_RULES = ("-p", "--param")
_EVERY_NODE = "/**"
# What launch calls the files in which it hands parameters to a node.
_OF_LAUNCH = "launch_params_"


@frozen
class _File:
    path: str
    text: str
    """Text for rcl."""
    is_as_it_stands: bool
    """Whether rcl can read the file itself."""
    sections: Sections


class RosArguments:
    """Knows the values written for a node, and gives rcl its arguments."""

    def __init__(self, arguments: Sequence[str]) -> None:
        """Read the named files; leave unreadable ones to rcl.

        Args:
            arguments: The arguments from each `--ros-args` up to `--` or the end.
        """
        self._arguments = list(arguments)
        self._files: dict[int, _File] = {}
        self._sections: Sections = {}
        self._copies: dict[str, str] = {}
        for at, word in enumerate(self._arguments[:-1], 1):
            value = self._arguments[at]
            if word == _FILE and (file := _read_file(value)):
                self._files[at] = file
                self._add(file.sections)
            elif word in _RULES and ":=" in value:
                self._arguments[at] = self._take_rule(value)

    @property
    def files(self) -> dict[str, Sections]:
        """Contents of each file, by the name that the user gave it."""
        return {file.path: file.sections for file in self._files.values()}

    def written_for(self, node_name: str) -> dict[str, list[Written | None]]:
        """Return the values written for the parameters of a node, as rcl resolves names.

        Args:
            node_name: The full name of the node.
        """
        found: dict[str, list[Written | None]] = {}
        for section, parameters in self._sections.items():
            if _applies(section, node_name):
                found |= parameters
        return found

    @contextmanager
    def for_rcl(self) -> Iterator[list[str]]:
        """Yield arguments for rcl; the copies of files among them end with the block."""
        with ExitStack() as stack:
            arguments = list(self._arguments)
            for at, file in self._files.items():
                if not file.is_as_it_stands:
                    arguments[at] = stack.enter_context(_copy(file.text))
                    self._copies[arguments[at]] = file.path
            yield arguments

    def named_by_user(self, text: str) -> str:
        """Return rcl's message, with the user's names of the files."""
        for copy, path in self._copies.items():
            text = text.replace(copy, path)
        return text

    def _take_rule(self, rule: str) -> str:
        """Note a value of `-p`; return it as rcl takes it."""
        left, _, text = rule.partition(":=")
        section, is_given, name = left.partition(":")
        if not is_given:
            section, name = _EVERY_NODE, left
        written = read_value(text)
        self._add({section: {name: [written]}})
        return f"{left}:={_value_for_rcl(text, written)}"

    def _add(self, sections: Sections) -> None:
        for section, parameters in sections.items():
            known = self._sections.setdefault(section, {})
            for name, written in parameters.items():
                known.setdefault(name, []).extend(written)


def _value_for_rcl(text: str, written: Written) -> str:
    if isinstance(written, WrittenText):
        # Where it is no YAML, or would be none without a word.
        return quoted(text) if written == WrittenText(text, is_quoted=True) else text
    return f"[{', '.join(quoted(item.text) for item in written)}]" if is_mixed(written) else text


def _applies(section: str, node_name: str) -> bool:
    """Return whether a section is for a node, as in rclpy: `*` is one name, `**` any number."""
    pattern = re.escape(section if section.startswith("/") else f"/{section}")
    pattern = pattern.replace(r"/\*\*", r"(/\w+)*").replace(r"/\*", r"(/\w+)")
    return bool(re.fullmatch(pattern, node_name, re.ASCII))


def _read_file(path: str) -> _File | None:
    try:
        text = Path(path).read_text(encoding="utf-8")
        is_regular = stat.S_ISREG(Path(path).stat().st_mode)
    except (OSError, ValueError):
        return None
    documents = read_documents(text)
    is_dumped = Path(path).name.startswith(_OF_LAUNCH)
    sections: Sections = {}
    for entry in entries(documents):
        parameters = sections.setdefault(entry.section, {})
        written = written_of(entry.node, is_dumped=is_dumped)
        parameters.setdefault(entry.name, []).append(written)
    # A pipe, such as `<(...)` of a shell, has been read once and for all.
    taken = for_rcl(text, documents)
    return _File(path, taken, is_regular and taken == text, sections)


@contextmanager
def _copy(text: str) -> Iterator[str]:
    """Create a file in memory, which the system always removes with this process."""
    descriptor = os.memfd_create("params.yaml")
    try:
        with open(descriptor, "w", encoding="utf-8", closefd=False) as file:
            file.write(text)
        yield f"/proc/self/fd/{descriptor}"
    finally:
        os.close(descriptor)
