"""`rosbase topic echo`, `hz`, `bw` and `delay`."""

from __future__ import annotations

import sys

from rosbase.cli.operate.reading import UsageError
from rosbase.control.names import full_type
from rosbase.control.questions.topics import TopicQuestions
from rosbase.errors import ControlError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import Any

    from rosbase.control.watching import Heard

__all__ = ["bandwidth", "delay", "echo", "rate"]

# Messages that wait in the program, such as for a terminal that stops for a moment.
_MOST_WAITING = 1_000
_MOST_DIGITS = 9


def echo(given: Any) -> int:
    """Print messages as `ros2 topic echo` does, until Ctrl-C; the status tells of none."""
    from rosbase.cli.operate.message_text import writer_for

    if given.json and given.csv:
        raise UsageError("--json and --csv: choose one")
    write = writer_for(given)
    questions = TopicQuestions(given.program)
    _check_type(questions, given)
    number, lost = 0, 0
    for heard in questions.echo(given.topic, limit=_MOST_WAITING, timeout_s=given.timeout):
        print(_shown(heard, given.field, write), end="", flush=True)
        number += 1
        if given.once:
            break
        if heard.dropped > lost and not given.no_lost_messages:
            lost = heard.dropped
            print(f"rosbase: {lost} messages lost so far", file=sys.stderr)
    return 0 if number else _nothing(given)


def _check_type(questions: TopicQuestions, given: Any) -> None:
    topic = questions.topic(given.topic)
    if given.type is not None and full_type(given.type) not in topic["types"]:
        text = f"topic {topic['name']} is of type {topic['types'][0]}, not {given.type}"
        raise ControlError(text, "invalid")
    if not topic["publishers"] and given.program is None:
        print(f"rosbase: no program publishes {topic['name']} yet", file=sys.stderr)


def _shown(heard: Heard, field: str | None, write: Callable[[Any], str]) -> str:
    value: Any = heard.message
    for name in field.replace("[", ".[").split(".") if field else ():
        if name.startswith("[") and isinstance(value, (tuple, list, memoryview)):
            value = _element(value, name, heard.type, field)
            continue
        if not isinstance(value, dict) or name not in value:
            known = f"; there are: {', '.join(value)}" if isinstance(value, dict) else ""
            raise ControlError(f"{heard.type} has no field {field}{known}", "unknown")
        value = value[name]
    return write(value)


def _element(values: Sequence[Any], index: str, kind: str, field: str | None) -> Any:
    """Return the element of a list that a part of a field such as `[3]` names."""
    digits = index[1:-1]
    if not index.endswith("]") or not digits.isdecimal() or len(digits) > _MOST_DIGITS:
        raise ControlError(f"{kind} has no field {field}: {index} is no index", "unknown")
    if int(digits) >= len(values):
        text = f"{kind} has no field {field}: the list has {len(values)} elements"
        raise ControlError(text, "unknown")
    return values[int(digits)]


def _nothing(given: Any) -> int:
    print(f"rosbase: nothing was published on {given.topic}", file=sys.stderr)
    return 1


def rate(given: Any) -> int:
    """Print the rate of a topic each second, as `ros2 topic hz` does."""
    return _report(given, "interval", _rate_text)


def bandwidth(given: Any) -> int:
    """Print the bandwidth of a topic each second, as `ros2 topic bw` does."""
    return _report(given, "bytes", _bandwidth_text)


def delay(given: Any) -> int:
    """Print the age of the messages each second, as `ros2 topic delay` does."""
    return _report(given, "delay", _delay_text)


def _report(given: Any, measure: str, text_of: Callable[[Any], str]) -> int:
    from rosbase.cli.operate.pool import Pool

    questions = TopicQuestions(given.program)
    if measure == "bytes":
        print(f"Subscribed to [{questions.topic(given.topic)['name']}]", flush=True)
    pool = Pool(given.window, measure)
    for report in questions.count(given.topic, measures=[measure]):
        if pool.add(report["window"]):
            print(text_of(pool), flush=True)
        elif pool.count:
            print("no new messages", flush=True)
    return 0 if pool.count else _nothing(given)


def _rate_text(pool: Any) -> str:
    hz = 1e9 / pool.mean if pool.mean else 0.0
    return f"average rate: {hz:.3f}\n\t{_spread(pool)}"


def _delay_text(pool: Any) -> str:
    return f"average delay: {pool.mean / 1e9:.3f}\n\t{_spread(pool)}"


def _spread(pool: Any) -> str:
    low, high, std = pool.least / 1e9, pool.most / 1e9, pool.std / 1e9
    return f"min: {low:.3f}s max: {high:.3f}s std dev: {std:.5f}s window: {pool.count}"


def _bandwidth_text(pool: Any) -> str:
    per_s = pool.mean * pool.count / pool.seconds if pool.seconds else 0.0
    size, unit = (1, "B") if per_s < 1e3 else (1e3, "KB") if per_s < 1e6 else (1e6, "MB")
    digits = 0 if unit == "B" else 2
    speed, mean, least, most = (
        f"{value / size:.{digits}f} {unit}" for value in (per_s, pool.mean, pool.least, pool.most)
    )
    return (
        f"{speed}/s from {pool.count} messages\n"
        f"\tMessage size mean: {mean} min: {least} max: {most}"
    )
