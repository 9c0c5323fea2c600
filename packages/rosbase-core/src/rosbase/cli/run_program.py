"""`rosbase run`: run a program as it is, with parameters, a backend and log levels from outside."""

import argparse
import os
import sys

from rosbase.program.arguments import add_arguments, take_arguments
from rosbase.roles.recording import RECORD_VARIABLE

__all__ = ["configure", "run"]

_HASH_SEED = "PYTHONHASHSEED"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = (
        "a manager, a node or a function:\n"
        "  rosbase run robot.py\n"
        "  rosbase run my_robot.app:RobotManager -p camera.fps:=30 --params-file robot.toml"
    )
    add_arguments(parser)
    parser.add_argument(
        "target", metavar="PROGRAM", help="a file, a module, or a class or function: module:Name"
    )
    parser.add_argument(
        "arguments",
        metavar="...",
        nargs=argparse.REMAINDER,
        help="the same options, and arguments of the program itself",
    )


def run(arguments: argparse.Namespace) -> int:
    """Replace this process by the program."""
    rest = take_arguments(arguments.arguments, before=arguments)
    theirs = arguments.backend_arguments
    words = [arguments.target, *rest, *(theirs[1:] if theirs[:1] == ["--"] else theirs)]
    if RECORD_VARIABLE in os.environ:
        _fix_hash_seed()
    sys.stdout.flush()
    os.execv(sys.executable, [sys.executable, "-m", "rosbase.program", *words])


def _fix_hash_seed() -> None:
    """Choose the order of sets of texts for the program, so that a replay can have the same."""
    if not os.environ.get(_HASH_SEED, "").isdecimal():
        os.environ[_HASH_SEED] = str(int.from_bytes(os.urandom(4), "little"))
