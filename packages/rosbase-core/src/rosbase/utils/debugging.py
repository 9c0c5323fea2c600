"""The argument `--debug`: wait for a debugger before the program runs."""

import argparse
import sys
from argparse import ArgumentParser, Namespace
from importlib import import_module
from typing import Any, NoReturn, TypeVar, overload

from rosbase.text.printable import one_line

__all__ = ["add_debug_mode"]

_PORT = 5678
"""The usual port of debugpy."""
_USAGE_ERROR = 2

TakenT = TypeVar("TakenT", ArgumentParser, Namespace)


@overload
def add_debug_mode(args: None = None, listen_port: int = _PORT) -> Namespace: ...
@overload
def add_debug_mode(args: TakenT, listen_port: int = _PORT) -> TakenT: ...
def add_debug_mode(
    args: ArgumentParser | Namespace | None = None, listen_port: int = _PORT
) -> ArgumentParser | Namespace:
    """Wait for a debugger if the command line has `--debug`; this needs debugpy.

    The program listens on this machine only, and goes on once an editor has attached.

    Args:
        args: A parser, to which the argument is added: the program waits while it parses its
            arguments. Or parsed arguments: the program waits now, if their `debug` is true. None
            looks for `--debug` on the command line, and leaves everything on it to the program.
        listen_port: TCP port for the debugger.

    Returns:
        The parser or the arguments given; of None, arguments with `debug`.

    Raises:
        SystemExit: debugpy is not installed, or the port is taken. The message is one line.
    """
    if isinstance(args, ArgumentParser):
        args.add_argument(
            "--debug",
            action=_WaitForDebugger,
            port=listen_port,
            help=f"wait for a debugger (debugpy) on port {listen_port}",
        )
        return args
    if args is None:
        args = Namespace(debug="--debug" in sys.argv[1:])
    if getattr(args, "debug", False):
        _wait(ArgumentParser(), listen_port)
    return args


class _WaitForDebugger(argparse.Action):
    def __init__(self, *, port: int, **options: Any) -> None:
        super().__init__(nargs=0, default=False, **options)
        self._port = port

    def __call__(self, parser: ArgumentParser, namespace: Namespace, *others: Any) -> None:
        setattr(namespace, self.dest, True)
        _wait(parser, self._port)


def _wait(parser: ArgumentParser, port: int) -> None:
    try:
        debugpy: Any = import_module("debugpy")
    except ImportError:
        _end(parser, "--debug needs debugpy: pip install debugpy")
    try:
        debugpy.listen(("127.0.0.1", port))
    except (OSError, RuntimeError) as error:
        _end(parser, f"cannot listen on port {port} for a debugger: {error}")
    print(f"waiting for a debugger on port {port}", file=sys.stderr, flush=True)
    debugpy.wait_for_client()


def _end(parser: ArgumentParser, fault: str) -> NoReturn:
    parser.exit(_USAGE_ERROR, f"{parser.prog}: error: {one_line(fault)}\n")
