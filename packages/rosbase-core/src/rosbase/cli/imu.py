"""`rosbase imu`: run the reader on a device."""

import argparse

from rosbase.cli.arguments import (
    add_parameters,
    check_given,
    positive_number,
    read_given,
    with_spellings,
)
from rosbase.cli.console import add_log_level, log_to_stderr
from rosbase.cli.counts_help import COUNTS_HELP
from rosbase.cli.parameter_list import parameter_table
from rosbase.cli.session import ReaderManager, run_to_end
from rosbase.imu.settings import DEFAULT_TRANSPORT, reader_parameters
from rosbase.parameters import ParameterValue
from rosbase.plugins import installed_plugins

__all__ = ["configure", "run"]

# Here nobody else would bring the node up.
_OWN_DEFAULTS: dict[str, ParameterValue] = {"autostart": "activate"}
_SPELLINGS = {"transport": "comm_t"}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = COUNTS_HELP
    add_parameters(parser)
    parser.add_argument(
        "--duration", type=positive_number, metavar="S", help="end after this many seconds"
    )
    parser.add_argument(
        "--topic-echo",
        action="store_true",
        help="print each sample as one line of JSON; everything else goes to stderr",
    )
    parser.add_argument(
        "--managed",
        action="store_true",
        help="start unconfigured, so that another program brings it up; show only the log",
    )
    add_log_level(parser)
    parser.add_argument("--backend", help="the backend that carries the topics (default: local)")
    parser.add_argument(
        "--list-parameters", action="store_true", help="list the parameters and end"
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the reader until it is stopped."""
    log = log_to_stderr(arguments.log_level)
    registry = installed_plugins()
    specs = reader_parameters(registry)
    if arguments.list_parameters:
        print("\n".join(parameter_table(specs, registry.transports, _OWN_DEFAULTS)))
        return 0
    given = with_spellings(read_given(arguments.assignments, arguments.params_file), _SPELLINGS)
    # First, because a transport that is not installed leaves its parameters unknown.
    registry.transport(given["comm_t"].text if "comm_t" in given else DEFAULT_TRANSPORT)
    manager = ReaderManager(
        check_given(specs, given),
        log,
        backend=arguments.backend,
        echoes=arguments.topic_echo,
        is_quiet=arguments.managed,
        duration_s=arguments.duration,
        parameter_defaults={} if arguments.managed else _OWN_DEFAULTS,
    )
    return run_to_end(manager)
