"""Topics that stand behind options, as in `rosbase record robot -o run.mcap imu/data`."""

import argparse
from collections.abc import Sequence
from typing import Any

__all__ = ["allow_intermixed"]


def allow_intermixed(parser: argparse.ArgumentParser) -> None:
    """Let words stand before and behind options.

    By itself, argparse takes all words of a command that stand together, and refuses later ones.
    It has another method for this, which the parser of `rosbase` does not call for a command.
    """
    plain = parser.parse_known_args
    is_within = False

    def parse(args: Sequence[str] | None = None, namespace: Any = None) -> Any:
        nonlocal is_within
        if is_within:
            # The other method calls this one twice.
            return plain(args, namespace)
        is_within = True
        try:
            return parser.parse_known_intermixed_args(args, namespace)
        finally:
            is_within = False

    parser.parse_known_args = parse  # type: ignore[assignment,method-assign]  # see above
