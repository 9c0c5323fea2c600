"""Parameter files and values of `-p` as text: nodes, parameters and values."""

import base64
import binascii
from collections.abc import Iterator, Sequence
from typing import TypeAlias

import yaml
from attrs import frozen

from rosbase import Written, WrittenText
from rosbase_ros2.written.guess import is_mixed

__all__ = [
    "Entry",
    "Sections",
    "entries",
    "for_rcl",
    "quoted",
    "read_documents",
    "read_value",
    "written_of",
]

_PARAMETERS = "ros__parameters"
_BINARY = "tag:yaml.org,2002:binary"
_STRING = "tag:yaml.org,2002:str"
_QUOTES = ("'", '"')

Sections: TypeAlias = dict[str, dict[str, list[Written | None]]]
"""All texts of a parameter, by the name of the node in the file and the name of the parameter.

The last one counts. None is a value whose text is lost.
"""


@frozen
class Entry:
    """A parameter in a file."""

    section: str
    """Name of the node, or a pattern of names."""
    name: str
    node: yaml.Node


class _Loader(yaml.SafeLoader):  # type: ignore[misc]  # PyYAML has no types
    """A loader that refuses aliases, as rcl does: a small file could stand for an endless tree."""

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("an alias")
        return super().compose_node(parent, index)


def read_documents(text: str) -> list[yaml.Node]:
    """Return the documents of a file; none if it is not YAML, which rcl then reports."""
    try:
        return [node for node in yaml.compose_all(text, Loader=_Loader) if node]
    except (yaml.YAMLError, ValueError, RecursionError):
        return []


def entries(documents: Sequence[yaml.Node]) -> Iterator[Entry]:
    """Yield every parameter, in the order of the file."""
    for document in documents:
        yield from _sections(document, ())


def read_value(text: str) -> Written:
    """Return the value after `:=`; it is text if it is neither a scalar nor a flat list."""
    documents = read_documents(text)
    written = _written(documents[0]) if len(documents) == 1 else None
    if written is not None:
        items = (written,) if isinstance(written, WrittenText) else written
        if all(item.text or item.is_quoted for item in items):
            return written
    return WrittenText(text, is_quoted=True)


def written_of(node: yaml.Node, *, is_dumped: bool) -> Written | None:
    """Return the value of a node; None if its text says no more than rcl's guess.

    Args:
        node: A value in a file.
        is_dumped: Whether a tool such as launch has written the file. Then the tool has guessed
            its numbers and bools.
    """
    written = _written(node)
    if is_dumped and written is not None:
        items = node.value if isinstance(node, yaml.SequenceNode) else [node]
        if any(item.tag not in (_STRING, _BINARY) for item in items):
            return None
    return written


def for_rcl(text: str, documents: Sequence[yaml.Node]) -> str:
    """Return the text of a file, with quoted items in each list that rcl would refuse."""
    pieces, rest = [], len(text)
    mixed = [entry.node for entry in entries(documents) if _is_mixed(entry.node)]
    for item in sorted((item for node in mixed for item in node.value), key=_start, reverse=True):
        start, end = item.start_mark.index, item.end_mark.index
        pieces += [text[end:rest], quoted(item.value)]
        rest = start
    return "".join([text[:rest], *reversed(pieces)])


def quoted(text: str) -> str:
    """Return a text in YAML's double quotes."""
    return f'"{"".join(map(_escaped, text))}"'


def _escaped(sign: str) -> str:
    if sign in '"\\':
        return f"\\{sign}"
    # libyaml refuses what cannot be printed, and halves of a surrogate pair as JSON has them.
    return sign if sign.isprintable() else f"\\U{ord(sign):08X}"


def _start(node: yaml.Node) -> int:
    return int(node.start_mark.index)


def _is_mixed(node: yaml.Node) -> bool:
    written = _written(node)
    return isinstance(written, tuple) and is_mixed(written)


def _sections(node: yaml.Node, path: tuple[str, ...]) -> Iterator[Entry]:
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            if key.value == _PARAMETERS:
                yield from _parameters(value, "/".join(path), "")
            else:
                yield from _sections(value, (*path, str(key.value)))


def _parameters(node: yaml.Node, section: str, prefix: str) -> Iterator[Entry]:
    for key, value in node.value if isinstance(node, yaml.MappingNode) else ():
        name = f"{prefix}{key.value}"
        if isinstance(value, yaml.MappingNode):
            yield from _parameters(value, section, f"{name}.")
        else:
            yield Entry(section, name, value)


def _written(node: yaml.Node) -> Written | None:
    if isinstance(node, yaml.ScalarNode):
        return _text(node)
    if isinstance(node, yaml.SequenceNode) and all(
        isinstance(item, yaml.ScalarNode) for item in node.value
    ):
        return tuple(_text(item) for item in node.value)
    return None


def _text(node: yaml.ScalarNode) -> WrittenText:
    data = None
    if node.tag == _BINARY:
        try:
            data = base64.b64decode(node.value)
        except (binascii.Error, ValueError):
            pass
    return WrittenText(node.value, node.style in _QUOTES, data)
