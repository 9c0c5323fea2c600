"""The part of a recording that a user asks for."""

import argparse
from typing import Any, BinaryIO

from rosbase import ConfigurationError
from rosbase_mcap.commands.intermixed import allow_intermixed
from rosbase_mcap.quantities import moments_ns
from rosbase_mcap.reading import Selection, read_summary
from rosbase_mcap.recovery import mend

__all__ = ["add_selection", "selection_of"]


def add_selection(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that choose topics and times."""
    parser.add_argument("topics", nargs="*", metavar="TOPIC", help="topics; by default, all")
    moment = "a date in UTC, or a time span from the start such as 10s"
    parser.add_argument("--from", dest="start", metavar="TIME", help=f"begin here: {moment}")
    parser.add_argument("--to", dest="end", metavar="TIME", help=f"end here: {moment}")
    allow_intermixed(parser)


def selection_of(arguments: Any, stream: BinaryIO) -> Selection:
    """Return the part that was chosen.

    Raises:
        ConfigurationError: A topic is not in the file, or a time is wrong.
    """
    summary = read_summary(stream) or mend(stream, lambda data: None).summary
    there = {channel.topic for channel in summary.channels.values()}
    topics = [_full(topic, there) for topic in arguments.topics]
    first_ns = summary.start_ns or 0
    try:
        start, end = moments_ns(arguments.start, arguments.end, first_ns)
    except argparse.ArgumentTypeError as error:
        raise ConfigurationError(str(error)) from None
    return Selection(frozenset(topics), start, end)


def _full(topic: str, there: set[str]) -> str:
    full = topic if topic in there else f"/{topic.lstrip('/')}"
    if full not in there:
        known = ", ".join(sorted(there)) or "none"
        raise ConfigurationError(f"no topic {topic} in this recording; there are: {known}")
    return full
