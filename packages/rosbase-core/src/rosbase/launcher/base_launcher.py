"""Launch the programs of a file from a script: the launcher of ros_base."""

import argparse
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rosbase.clock import SystemClock
from rosbase.errors import ConfigurationError
from rosbase.launcher.control import control_of
from rosbase.launcher.description import Description, Fault
from rosbase.launcher.display import Terminal
from rosbase.launcher.finding import read_checked
from rosbase.launcher.launches import launch_of
from rosbase.launcher.ready_programs import ControlReadiness
from rosbase.launcher.run import Run
from rosbase.launcher.selection import choose
from rosbase.text.printable import printable

__all__ = ["BaseLauncher", "LaunchFileError", "add_options"]


class LaunchFileError(ConfigurationError):
    """A file of the launcher has mistakes. The message has one line for each of them."""

    def __init__(self, faults: Sequence[Fault]) -> None:
        """Take the mistakes, in the order of the file."""
        super().__init__("\n".join(map(str, faults)))
        self.faults = tuple(faults)
        """The mistakes, each with its line."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the launcher to a parser."""
    parser.add_argument(
        "--enable",
        metavar="NAME",
        nargs="+",
        action="extend",
        default=[],
        help="start these programs even if autostart is false",
    )
    parser.add_argument(
        "--disable",
        metavar="NAME",
        nargs="+",
        action="extend",
        default=[],
        help="do not start these programs; beats --enable",
    )
    parser.add_argument(
        "--tmux", action="store_true", help="give each program a pane of a tmux session, and return"
    )
    parser.add_argument(
        "--check", action="store_true", help="name every mistake in the file, and start nothing"
    )


class BaseLauncher:
    """Starts the programs of a file, and stops them all together.

    `BaseLauncher("robot.yaml").launch()` in a script beside the file makes a launcher of its own.
    The script takes the options of `rosbase up` from its command line: `--enable NAME...`,
    `--disable NAME...`, `--tmux` and `--check`.
    """

    def __init__(
        self,
        config: str | Path | Mapping[str, Any] | None = None,
        enable_nodes: Iterable[str] = (),
        disable_nodes: Iterable[str] = (),
        *,
        tmux: bool = False,
        arguments: Sequence[str] | None = None,
    ) -> None:
        """Prepare a launch; nothing is read yet.

        Args:
            config: Name of a YAML or TOML file, which is looked for in the working directory and
                then beside the script; or a mapping with the same content. None: the command line
                names the file.
            enable_nodes: Programs that start whatever their `autostart` says.
            disable_nodes: Programs that do not start, even if they are enabled.
            tmux: Whether each program gets a pane of a tmux session.
            arguments: Command line; by default the script's.
        """
        self._config = config
        self._enable, self._disable = _names(enable_nodes), _names(disable_nodes)
        self._tmux = tmux
        self._arguments = arguments

    def launch(self) -> None:
        """Start the programs, and return when all have ended; with tmux, once they are started.

        Ctrl-C stops them in the reverse order. A mistake in the file or on the command line is
        written to stderr before anything starts.

        Raises:
            SystemExit: The exit status is not 0: 2 for a mistake, otherwise that of the required
                program that has ended all, or 1 if another one has failed.
        """
        arguments = self._parsed()
        try:
            status = self.run(arguments)
        except ConfigurationError as error:
            print(_lines(error), file=sys.stderr)
            status = 2
        if status:
            sys.exit(status)

    def run(self, arguments: argparse.Namespace) -> int:
        """Do what the options say, and return the exit status. For `rosbase up`.

        Raises:
            ConfigurationError: The file has mistakes, or an option has.
        """
        description, faults = read_checked(self._named(arguments), _beside())
        found = faults.in_order()
        programs = list(description.programs)
        try:
            enabled = choose(
                programs, [*self._enable, *arguments.enable], [*self._disable, *arguments.disable]
            )
        except ConfigurationError as error:
            if not found:
                raise
            # All mistakes at once; without a program, the file is the reason.
            found += [Fault("", 0, str(error))] if programs else []
        if found:
            raise LaunchFileError(found)
        launches = {
            program.key: launch_of(session, program)
            for session in description.sessions
            for program in session.programs
        }
        if arguments.check:
            print(_praise(description, enabled))
            return 0
        if not enabled:
            raise ConfigurationError("no program starts: none is enabled")
        if arguments.tmux or self._tmux:
            from rosbase.launcher.tmux import start_in_tmux  # noqa: PLC0415 - few need it

            return start_in_tmux(description, enabled, launches)
        clock = SystemClock()
        show = Terminal([program.key for program in programs], clock)
        run = Run(programs, enabled, launches, show, ControlReadiness(), clock)
        with control_of(run, description):
            return run.run()

    def _parsed(self) -> argparse.Namespace:
        parser = argparse.ArgumentParser(description="Start the programs of a file.")
        if self._config is None:
            parser.add_argument("config", metavar="FILE", help="a YAML or TOML file")
        add_options(parser)
        return parser.parse_args(self._arguments)

    def _named(self, arguments: argparse.Namespace) -> str | Path | Mapping[str, Any]:
        if self._config is not None:
            return self._config
        named: str = arguments.config
        return named


def _names(given: Iterable[str]) -> list[str]:
    """Return the names; a text is one name."""
    return [given] if isinstance(given, str) else list(given)


def _beside() -> Path:
    """Return the folder of the script that runs."""
    main = getattr(sys.modules.get("__main__"), "__file__", None)
    return Path(main).resolve().parent if main else Path.cwd()


def _lines(error: ConfigurationError) -> str:
    return "\n".join(printable(line, 1000) for line in str(error).splitlines())


def _praise(description: Description, enabled: Sequence[str]) -> str:
    number = len(list(description.programs))
    where = f"{description.file}: " if description.file else ""
    return f"{where}no mistakes; {len(enabled)} of {number} programs start: {', '.join(enabled)}"
