"""`rosbase replay`: run a program in virtual time, fed from a recording."""

import argparse
import os
import sys
from pathlib import Path
from typing import Any

from attrs import evolve

from rosbase import ConfigurationError, take_arguments
from rosbase_mcap.bags import is_mcap, open_bag
from rosbase_mcap.commands.intermixed import allow_intermixed
from rosbase_mcap.quantities import moments_ns
from rosbase_mcap.replaying.options import ReplayOptions, check_options
from rosbase_mcap.replaying.run_file import RunFile, open_run
from rosbase_mcap.surroundings import restored_environment

__all__ = ["configure", "run"]

_MODULE = "rosbase_mcap.replaying"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("file", type=Path, metavar="FILE", help="the recording, or a bag of ROS")
    parser.add_argument(
        "program",
        nargs="?",
        metavar="PROGRAM",
        help="as for `rosbase run`; by default, the one that was recorded",
    )
    inputs = parser.add_mutually_exclusive_group()
    inputs.add_argument(
        "--frames",
        action="store_true",
        help="replay all inputs: frames of devices, messages from outside, requests, signals",
    )
    inputs.add_argument(
        "--topics",
        nargs="*",
        metavar="TOPIC",
        help="replay messages of these topics only; by default, those that the program reads",
    )
    speed = parser.add_mutually_exclusive_group()
    speed.add_argument("--rate", type=_rate, metavar="R", help="times real time (1)")
    speed.add_argument("--as-fast", action="store_true", help="as fast as possible")
    moment = "a date in UTC, or a time span from the start such as 10s"
    parser.add_argument("--from", dest="start", metavar="TIME", help=f"show from here on: {moment}")
    parser.add_argument("--to", dest="end", metavar="TIME", help=f"end here: {moment}")
    parser.add_argument(
        "--check",
        action="store_true",
        help="compare what the program publishes with the recording, as fast as possible",
    )
    allow_intermixed(parser)


def run(arguments: Any) -> int:
    """Replace this process by the program."""
    path: Path = arguments.file
    recorded = open_run(path) if is_mcap(path) else None
    options = _options(arguments, recorded)
    check_options(options, recorded)
    if options.checks and recorded is not None:
        recorded.check_undamaged()
    words = arguments.backend_arguments[1:]
    facts = recorded.run.facts.more if recorded is not None else {}
    argv = facts.get("argv")
    own = [str(word) for word in argv] if isinstance(argv, list) else []
    program = arguments.program or next(iter(own), "")
    if not program:
        raise ConfigurationError(f"{path} names no program: give it after the file")
    if options.topics is None:
        if words:
            raise ConfigurationError("a replay has the arguments of the recording: leave out --")
        command, environment = [program, *own[1:]], restored_environment(facts)
    else:
        command = [program, *take_arguments(words)]
        environment = dict(os.environ)
    sys.stdout.flush()
    python = [sys.executable, "-m", _MODULE, options.to_text()]
    os.execve(sys.executable, [*python, *command], environment)


def _options(arguments: Any, recorded: RunFile | None) -> ReplayOptions:
    topics = arguments.topics
    if topics is None and not arguments.frames and recorded is None:
        # There is nothing else in it.
        if arguments.check:
            raise ConfigurationError(f"{arguments.file} has topics only: nothing can be compared")
        topics = []
    if topics is not None:
        topics = [f"/{topic.lstrip('/')}" for topic in topics]
    rate = None if arguments.as_fast or arguments.check else 1.0
    options = ReplayOptions(arguments.file, topics, arguments.rate or rate, checks=arguments.check)
    if arguments.start is None and arguments.end is None:
        return options
    first_ns = recorded.run.facts.start_date_ns if recorded is not None else _start_ns(options.path)
    try:
        start, end = moments_ns(arguments.start, arguments.end, first_ns)
    except argparse.ArgumentTypeError as error:
        raise ConfigurationError(str(error)) from None
    since_ns = 0 if start is None else max(0, start - first_ns)
    return evolve(options, start_ns=since_ns, end_ns=None if end is None else end - first_ns)


def _start_ns(path: Path) -> int:
    with open_bag(path) as bag:
        return bag.start_ns


def _rate(text: str) -> float:
    try:
        rate = float(text.removesuffix("x"))
    except ValueError:
        rate = 0.0
    if not 0 < rate < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number")
    return rate
