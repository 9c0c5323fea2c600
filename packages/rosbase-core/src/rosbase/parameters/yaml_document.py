"""Parameter files of ROS 2 as written: nodes, parameters and values. Needs PyYAML."""

import base64
import binascii
from collections.abc import Iterator, Sequence

import yaml
from attrs import frozen

from rosbase.parameters.written import Written, WrittenText

__all__ = ["Entry", "as_written", "compose", "entries"]

_PARAMETERS = "ros__parameters"
_BINARY = "tag:yaml.org,2002:binary"
_QUOTES = ("'", '"')


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


def compose(text: str) -> list[yaml.Node]:
    """Return the documents of a file.

    Raises:
        ValueError: It is not YAML, or has an alias.
    """
    try:
        return [node for node in yaml.compose_all(text, Loader=_Loader) if node]
    except (yaml.YAMLError, RecursionError) as error:
        raise ValueError(str(error) or "nested too deeply") from error


def entries(documents: Sequence[yaml.Node]) -> Iterator[Entry]:
    """Yield every parameter, in the order of the file."""
    for document in documents:
        yield from _sections(document, ())


def as_written(node: yaml.Node) -> Written | None:
    """Return the value of a node; None if it is neither a scalar nor a flat list."""
    if isinstance(node, yaml.ScalarNode):
        return _text(node)
    if isinstance(node, yaml.SequenceNode) and all(
        isinstance(item, yaml.ScalarNode) for item in node.value
    ):
        return tuple(_text(item) for item in node.value)
    return None


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


def _text(node: yaml.ScalarNode) -> WrittenText:
    data = None
    if node.tag == _BINARY:
        try:
            data = base64.b64decode(node.value)
        except (binascii.Error, ValueError):
            pass
    return WrittenText(node.value, node.style in _QUOTES, data)
