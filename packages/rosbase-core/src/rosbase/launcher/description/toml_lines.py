"""Find the lines of keys in TOML. Python's parser does not tell them.

The text is known to be TOML, so this looks only for the beginnings of statements: a header in
brackets, or a key. What is within an inline table has the line of the statement.
"""

import re
from typing import Any

__all__ = ["lines_of"]

# A string of any form, a comment, a bracket, or an end of a line.
_TOKEN = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'|#[^\n]*|[\[\]{}]|\n',
    re.DOTALL,
)
_KEY_PART = re.compile(r'\s*(?:"((?:\\.|[^"\\])*)"|\'([^\']*)\'|([A-Za-z0-9_-]+))\s*(\.)?')


def lines_of(text: str) -> dict[tuple[Any, ...], int]:
    """Return the line of each key and of each table, by its path; lists count from 0."""
    lines: dict[tuple[Any, ...], int] = {}
    lengths: dict[tuple[Any, ...], int] = {}
    table: tuple[Any, ...] = ()
    for line, statement in _statements(text):
        is_list = statement.startswith("[[")
        keys = _keys(statement.lstrip("["))
        if not statement.startswith("["):
            _note(lines, (*table, *keys), len(table), line)
            continue
        table = _within(keys[:-1], lengths)
        if is_list:
            path = (*table, *keys[-1:])
            lengths[path] = lengths.get(path, 0) + 1
            table = (*path, lengths[path] - 1)
            lines.setdefault(path, line)
        else:
            table = _within(keys, lengths)
        _note(lines, table, 0, line)
    return lines


def _note(lines: dict[tuple[Any, ...], int], path: tuple[Any, ...], begin: int, line: int) -> None:
    for length in range(begin + 1, len(path) + 1):
        lines.setdefault(path[:length], line)


def _within(keys: tuple[str, ...], lengths: dict[tuple[Any, ...], int]) -> tuple[Any, ...]:
    """Return the path of a header; a list on the way stands for its last table so far."""
    path: tuple[Any, ...] = ()
    for key in keys:
        path = (*path, key)
        if path in lengths:
            path = (*path, lengths[path] - 1)
    return path


def _keys(text: str) -> tuple[str, ...]:
    keys, at = [], 0
    while part := _KEY_PART.match(text, at):
        keys.append(next(group for group in part.groups()[:3] if group is not None))
        at = part.end()
        if not part[4]:
            break
    return tuple(keys)


def _statements(text: str) -> list[tuple[int, str]]:
    """Return the line and the text of each statement, as far as its first line end."""
    found: list[tuple[int, str]] = []
    begin, line, depth, at_line = 0, 1, 0, 1
    for token in [*_TOKEN.finditer(text), None]:
        if token is not None and token[0] != "\n":
            depth += (token[0] in "[{") - (token[0] in "]}")
            line += token[0].count("\n")
            continue
        if depth == 0:
            end = token.start() if token else len(text)
            statement = text[begin:end].strip()
            if statement and not statement.startswith("#"):
                found.append((at_line, statement))
            begin, at_line = end + 1, line + 1
        line += 1
    return found
