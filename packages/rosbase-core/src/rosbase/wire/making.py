"""Make messages of which only some numbers vary: everything else is prepared once."""

import itertools
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from rosbase.wire.description import Field, Kind, MessageType, describe
from rosbase.wire.filling import can_be_filled, filled
from rosbase.wire.source import Source
from rosbase.wire.varying import NS_PER_S, TIMES, arguments_of

__all__ = ["maker"]


def maker(
    template: Any, varying: Sequence[str], finish: Callable[[Any], Any] | None = None
) -> Callable[..., Any]:
    """Return a function that makes messages like the template, of the values of varying fields.

    It checks no value. A time or a duration is given as its nanoseconds, a message of numbers or
    an array as a sequence of its numbers, and a number as itself.

    Args:
        template: All that does not vary.
        varying: Paths of the fields that vary, such as `header.stamp` or `orientation`.
        finish: Called with each message, if given; the function returns its result.

    Raises:
        TypeError: The template is no message.
        ValueError: A path leads to no numbers; the text names it.
    """
    own = describe(type(template))
    arguments = arguments_of(own, varying)
    source = Source(f"make({', '.join(arguments.values())})")
    made = _expression(source, own, template, "", arguments)
    # One function instead of two, because a call costs a fiftieth of a sample.
    if finish is not None:
        made = f"{source.name_of(finish, 'finish')}({made})"
    source.line(f"return {made}")
    return source.compile()


def _expression(
    source: Source, of: MessageType, template: Any, prefix: str, arguments: dict[str, str]
) -> str:
    parts = []
    # An array may get too few or too many.
    must_check = False
    for one in of.fields:
        path, value = f"{prefix}{one.name}", getattr(template, one.name)
        if path in arguments:
            must_check = must_check or one.kind is Kind.ARRAY
            made = _value_made(source, one, arguments[path])
        elif any(varying.startswith(f"{path}.") for varying in arguments):
            assert isinstance(one.element, MessageType)
            made = _expression(source, one.element, value, f"{path}.", arguments)
        else:
            made = source.name_of(value, "fixed")
        parts.append((one, made))
    return _made(source, of, parts, must_check=must_check)


def _made(
    source: Source, of: MessageType, parts: list[tuple[Field, str]], *, must_check: bool = False
) -> str:
    """Return the expression of a message of these values, after lines that prepare it."""
    if must_check or not can_be_filled(of):
        kind = source.name_of(of.cls, "kind")
        return f"{kind}({', '.join(_argument(one, value) for one, value in parts)})"
    made, lines = filled(source, of, parts)
    for line in lines:
        source.line(line)
    return made


def _value_made(source: Source, one: Field, argument: str) -> str:
    """Return the expression that makes the value of a varying field."""
    of = one.element
    if not isinstance(of, MessageType):
        return argument if one.kind is Kind.ONE else f"tuple({argument})"
    is_time = of.name in TIMES and can_be_filled(of)
    if of.name in TIMES and not is_time:
        return f"{source.name_of(of.cls, 'kind')}.from_nanoseconds({argument})"
    if is_time or all(_is_number(inner) for inner in of.fields):
        numbers = f"divmod({argument}, {NS_PER_S})" if is_time else argument
        names = [source.new("number") for _ in of.fields]
        source.line(f"{', '.join(names)}, = {numbers}")
        return _made(source, of, list(zip(of.fields, names, strict=True)))
    return _message_made(source, of, argument, itertools.count())


def _argument(one: Field, value: str) -> str:
    # A call with names costs more.
    return f"{one.alias}={value}" if one.is_keyword else value


def _is_number(one: Field) -> bool:
    return one.kind is Kind.ONE and not isinstance(one.element, MessageType)


def _message_made(source: Source, of: MessageType, argument: str, next_: Iterator[int]) -> str:
    """Return the expression that makes a message of the next numbers of the argument."""
    parts = []
    for one in of.fields:
        if isinstance(one.element, MessageType):
            value = _message_made(source, one.element, argument, next_)
        elif one.kind is Kind.ONE:
            value = f"{argument}[{next(next_)}]"
        else:
            first, *_ = (next(next_) for _ in range(one.size))
            value = f"tuple({argument}[{first}:{first + one.size}])"
        parts.append(_argument(one, value))
    return f"{source.name_of(of.cls, 'kind')}({', '.join(parts)})"
