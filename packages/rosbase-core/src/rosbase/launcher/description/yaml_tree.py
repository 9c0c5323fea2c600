"""Read YAML into a tree with lines. Needs PyYAML."""

from typing import Any

import yaml

from rosbase.launcher.description.tree import Faults, Value

__all__ = ["read_yaml"]

_PLAIN = {f"tag:yaml.org,2002:{name}" for name in ("bool", "int", "float", "null")}
_MERGE = "tag:yaml.org,2002:merge"
_DEEPEST = 32
# Aliases let a small file stand for an endless tree.
_MOST_VALUES = 100_000


class _TooMuchError(Exception):
    """The file stands for more than any launcher's file has."""


class _Reader:
    def __init__(self, faults: Faults) -> None:
        self._faults = faults
        self._tools = yaml.SafeLoader("")
        self._left = _MOST_VALUES

    def tree(self, node: yaml.Node, line: int, depth: int = 0) -> Value:
        self._left -= 1
        if depth > _DEEPEST or self._left < 0:
            raise _TooMuchError
        if isinstance(node, yaml.MappingNode):
            return Value(self._entries(node, depth), line)
        if isinstance(node, yaml.SequenceNode):
            items = [self.tree(item, _line(item), depth + 1) for item in node.value]
            return Value(items, line)
        return self._scalar(node, line)

    def _entries(self, node: yaml.MappingNode, depth: int) -> dict[str, Value]:
        self._tools.flatten_mapping(node)
        entries = {}
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode):
                self._faults.add(_line(key), "a key is a text")
                continue
            entries[key.value] = self.tree(value, _line(key), depth + 1)
        return entries

    def _scalar(self, node: yaml.ScalarNode, line: int) -> Value:
        data: Any = node.value
        if node.tag in _PLAIN:
            try:
                data = self._tools.construct_object(node)
            except (yaml.YAMLError, ValueError, LookupError):
                # A number that only looks like one to the pattern of YAML, or `!!bool maybe`.
                pass
        return Value(data, line, node.value)


def read_yaml(text: str, faults: Faults) -> Value | None:
    """Return the tree of a file; None after noting why there is none. Aliases and `<<` work."""
    try:
        documents = [node for node in yaml.compose_all(text, Loader=yaml.SafeLoader) if node]
        if len(documents) != 1:
            why = "a second document begins here" if documents else "the file is empty"
            faults.add(_line(documents[1]) if documents else 0, why)
            return None
        _refuse_repeats(documents[0], faults)
        return _Reader(faults).tree(documents[0], _line(documents[0]))
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        faults.add(mark.line + 1 if mark else 0, f"not YAML: {error.problem or error}")
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        faults.add(line, f"not YAML: {error.reason}: #x{error.character:04x}")
    except (_TooMuchError, RecursionError):
        faults.add(0, "nested too deeply, or too large")
    except yaml.YAMLError as error:
        faults.add(0, f"not YAML: {error}")
    return None


def _refuse_repeats(root: yaml.Node, faults: Faults) -> None:
    """Note keys that a mapping has twice, before merged keys come to its own."""
    seen, left = {id(root)}, [root]
    while left:
        node = left.pop()
        within = [*node.value] if isinstance(node, yaml.SequenceNode) else []
        if isinstance(node, yaml.MappingNode):
            _refuse_repeats_in(node, faults)
            within = [value for _, value in node.value]
        left += [one for one in within if id(one) not in seen]
        seen.update(map(id, within))


def _refuse_repeats_in(node: yaml.MappingNode, faults: Faults) -> None:
    lines: dict[str, int] = {}
    for key, _ in node.value:
        name = str(key.value)
        if name in lines and key.tag != _MERGE:
            faults.add(_line(key), f"'{name}' is already in line {lines[name]}")
        lines.setdefault(name, _line(key))


def _line(node: yaml.Node) -> int:
    return int(node.start_mark.line) + 1
