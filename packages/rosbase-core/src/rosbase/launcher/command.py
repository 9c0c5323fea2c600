"""`rosbase up`: start the programs of a file, and stop them all together."""

import argparse
import sys

from rosbase.launcher.base_launcher import BaseLauncher, LaunchFileError, add_options

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = (
        "the programs of a robot, in their order:\n"
        "  rosbase up robot.yaml\n"
        "  rosbase up robot.yaml --disable CAMERA\n"
        "  rosbase up robot.yaml --check"
    )
    parser.add_argument("config", metavar="FILE", help="a YAML or TOML file")
    add_options(parser)


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    try:
        return BaseLauncher(arguments.config).run(arguments)
    except LaunchFileError as error:
        # Line by line, as compilers do, so that editors find them.
        print(error, file=sys.stderr)
        return 2
