"""`rosbase run`: run a program as it is, with parameters, a backend and log levels from outside."""

import argparse
import os
import sys

from rosbase.program.arguments import add_arguments, take_arguments

__all__ = ["configure", "run"]


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
    sys.stdout.flush()
    os.execv(sys.executable, [sys.executable, "-m", "rosbase.program", *words])
