"""The conditions under which a program starts, as they are written under `after`."""

import re
from collections.abc import Iterator
from typing import get_args

from rosbase.launcher.description.model import Condition, ConditionKind
from rosbase.launcher.description.tree import Faults, Value
from rosbase.parameters.checking import did_you_mean
from rosbase.text.printable import printable

__all__ = ["read_conditions"]

_KINDS: tuple[ConditionKind, ...] = get_args(ConditionKind)
_TOKEN = re.compile(r"\\.|\[\^?\]?(?:\\.|[^\]\\])*\]|[()]|[*+]|\{\d*,\}", re.DOTALL)
_LOG = re.compile(r"log\s*:\s*(.*)", re.DOTALL)


def read_conditions(value: Value, faults: Faults) -> Iterator[tuple[str, Condition, int]]:
    """Yield the name, the condition and the line of everything that `after` waits for.

    A text or a list of texts names programs that must have been started. A mapping has a
    condition for each name.
    """
    if isinstance(value.data, dict):
        for name, item in value.data.items():
            # Even if the condition is wrong, because the name may be wrong too.
            yield name, _condition(item, name, faults) or Condition(), item.line
    elif isinstance(value.data, list):
        for item in value.data:
            if isinstance(item.data, list):
                faults.add(item.line, "after is a name, a list of names, or a mapping")
            else:
                yield from read_conditions(item, faults)
    elif value.is_scalar:
        yield value.text, Condition(), value.line
    else:
        faults.add(value.line, f"after is a name, a list of names, or a mapping, not {value.kind}")


def _condition(value: Value, name: str, faults: Faults) -> Condition | None:
    if isinstance(value.data, dict) and list(value.data) == ["log"]:
        return _log(value.data["log"].text, value.line, faults)
    if value.data is None:
        return Condition()
    if not value.is_scalar:
        faults.add(value.line, f"the condition for '{printable(name)}' is a text, not {value.kind}")
        return None
    if written := _LOG.fullmatch(value.text.strip()):
        return _log(written[1], value.line, faults)
    text = " ".join(value.text.split())
    for kind in _KINDS:
        if text == kind and kind != "log":
            return Condition(kind)
    known = [kind for kind in _KINDS if kind != "log"]
    hint = did_you_mean(text, known) or f"; it is one of {', '.join(known)}, log: PATTERN"
    faults.add(value.line, f"there is no condition '{printable(text)}'{hint}")
    return None


def _log(pattern: str, line: int, faults: Faults) -> Condition | None:
    try:
        re.compile(pattern)
    except (re.error, OverflowError, RecursionError) as error:
        faults.add(line, f"the pattern {printable(pattern)!r} is no regular expression: {error}")
        return None
    if not pattern:
        faults.add(line, "log: needs a pattern")
        return None
    if _repeats_a_repetition(pattern):
        text = f"the pattern {printable(pattern)!r} repeats a repetition, as in (a+)+, which may"
        faults.add(line, f"{text} take for ever")
        return None
    return Condition("log", pattern)


def _repeats_a_repetition(pattern: str) -> bool:
    """Return whether a group without a limit has one more within; a search in it may never end."""
    # For each open group: whether there is a repetition in it. The first is the whole pattern.
    groups, closed, last, end = [False], False, False, 0
    for token in _TOKEN.finditer(pattern):
        word = token[0]
        follows_a_group = closed and token.start() == end
        closed = False
        if word == "(":
            groups.append(False)
        elif word == ")" and len(groups) > 1:
            closed, last, end = True, groups.pop(), token.end()
            groups[-1] |= last
        elif word[0] in "*+{":
            if follows_a_group and last:
                return True
            groups[-1] = True
    return False
