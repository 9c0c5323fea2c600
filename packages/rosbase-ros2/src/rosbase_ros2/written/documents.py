"""Parameter files and values of `-p` as text: nodes, parameters and values."""

from collections.abc import Sequence
from typing import TypeAlias

import yaml

from rosbase import Written, WrittenText
from rosbase.parameters.yaml_document import Entry, as_written, compose, entries
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

_BINARY = "tag:yaml.org,2002:binary"
_STRING = "tag:yaml.org,2002:str"

Sections: TypeAlias = dict[str, dict[str, list[Written | None]]]
"""All texts of a parameter, by the name of the node in the file and the name of the parameter.

The last one counts. None is a value whose text is lost.
"""


def read_documents(text: str) -> list[yaml.Node]:
    """Return the documents of a file; none if it is not YAML, which rcl then reports."""
    try:
        return compose(text)
    except ValueError:
        return []


def read_value(text: str) -> Written:
    """Return the value after `:=`; it is text if it is neither a scalar nor a flat list."""
    documents = read_documents(text)
    written = as_written(documents[0]) if len(documents) == 1 else None
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
    written = as_written(node)
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
    written = as_written(node)
    return isinstance(written, tuple) and is_mixed(written)
