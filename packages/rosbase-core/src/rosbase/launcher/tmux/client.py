"""The commands of tmux that the launcher uses."""

import os
import shutil
import subprocess

from attrs import frozen

from rosbase.errors import ConfigurationError
from rosbase.text.printable import one_line

__all__ = ["Pane", "Tmux", "session_size"]

_WINDOW = "MAIN"
# Columns and lines of a session that nobody's terminal gives a size; many panes need room. It takes
# the size of the terminal that attaches.
_LARGE = (240, 120)
# Lines that a pane needs, with its border.
_PANE_LINES = 6
_PANE = ("-P", "-F", "#{pane_id} #{pane_tty}")
_TIMEOUT_S = 20.0


def session_size(terminal: tuple[int, int] | None, panes: int) -> tuple[int, int]:
    """Return columns and lines for a session with that number of panes.

    They are the terminal's, so that nothing moves when it attaches; a larger size if the
    panes have no room there, or there is no terminal.
    """
    if terminal is None or panes > (terminal[1] // _PANE_LINES) ** 2:
        return _LARGE
    return terminal


@frozen
class Pane:
    """A pane of tmux."""

    number: str
    """Its unique name, such as `%3`."""
    terminal: str
    """Path of its terminal."""


class Tmux:
    """The tmux server of this user."""

    def __init__(self) -> None:
        """Find tmux.

        Raises:
            ConfigurationError: It is not installed.
        """
        found = shutil.which("tmux")
        if found is None:
            raise ConfigurationError("tmux is not installed: sudo apt install tmux")
        self._path = found

    def new_session(
        self, session: str, folder: str, command: str, size: tuple[int, int] = _LARGE
    ) -> Pane:
        """Open a detached session with one window and one pane that runs a command.

        Args:
            session: Its name.
            folder: Working directory of the command.
            command: Command of the shell.
            size: Columns and lines.
        """
        columns, lines = map(str, size)
        name = ("-d", "-s", _literal(session), "-n", _WINDOW)
        pane = self._pane(
            "new-session",
            *name,
            "-x",
            columns,
            "-y",
            lines,
            "-c",
            _literal(folder),
            *_PANE,
            command,
        )
        for option, value in (
            ("remain-on-exit", "on"),
            ("allow-rename", "off"),
            ("automatic-rename", "off"),
            ("pane-border-status", "top"),
            ("pane-border-format", " #{pane_title} "),
            # Its line, at the very bottom, would push the last words of the program out of sight.
            ("remain-on-exit-format", ""),
        ):
            # Quietly: tmux 3.2 does not know the last one.
            self.run("set-window-option", "-q", "-t", pane.number, option, value)
        return pane

    def add_pane(self, session: str, folder: str, command: str) -> Pane:
        """Open one more pane in the window of a session."""
        window = f"={session}:{_WINDOW}"
        pane = self._pane("split-window", "-t", window, "-c", _literal(folder), *_PANE, command)
        # After each, so that there is room for the next one.
        self.run("select-layout", "-t", window, "tiled")
        return pane

    def name_pane(self, pane: Pane, name: str) -> None:
        """Show the name of a program above its pane."""
        self.run("select-pane", "-t", pane.number, "-T", _literal(name))

    def respawn(self, pane: Pane, command: str) -> Pane:
        """Run a command in a pane whose command has ended; return it with its new terminal."""
        self.run("respawn-pane", "-t", pane.number, command)
        words = ("display-message", "-p", "-t", pane.number, "#{pane_tty}")
        return Pane(pane.number, self.run(*words).strip())

    def is_alive(self, pane: Pane) -> bool:
        """Return whether a pane exists and its command runs."""
        done = self._call("display-message", "-p", "-t", pane.number, "#{pane_id} #{pane_dead}")
        return done.stdout.strip() == f"{pane.number} 0"

    def look_for_ends(self) -> None:
        """Have tmux look for commands that have ended, by running one more that ends.

        On a busy machine, tmux 3.3 may miss the end of a command. Its pane then has no status
        until tmux hears of another end.
        """
        self._call("run-shell", "-b", "true")

    def copy_output(self, pane: Pane, command: str) -> None:
        """Give the output of a pane to the shell command as well."""
        self.run("pipe-pane", "-t", pane.number, _literal(command).replace("%", "%%"))

    def has_session(self, session: str) -> bool:
        """Return whether there is a session of exactly that name."""
        return self._call("has-session", "-t", f"={session}").returncode == 0

    def kill_session(self, session: str) -> None:
        """End a session and everything in its panes, if it exists."""
        self._call("kill-session", "-t", f"={session}")

    def note(self, session: str, name: str, value: str) -> None:
        """Keep a value with a session."""
        self.run("set-option", "-t", f"={session}:", f"@{name}", value)

    def noted(self, session: str, name: str) -> str:
        """Return a value kept with a session; empty if there is none."""
        done = self._call("show-options", "-v", "-t", f"={session}:", f"@{name}")
        return done.stdout.strip() if done.returncode == 0 else ""

    def run(self, *words: str) -> str:
        """Run a command of tmux, and return its output.

        Raises:
            OSError: tmux refuses.
        """
        done = self._call(*words)
        if done.returncode:
            raise OSError(f"tmux {words[0]}: {one_line(done.stderr or 'failed')}")
        return done.stdout

    def _pane(self, *words: str) -> Pane:
        number, _, terminal = self.run(*words).strip().partition(" ")
        return Pane(number, terminal)

    def _call(self, *words: str) -> "subprocess.CompletedProcess[str]":
        try:
            return subprocess.run(
                [self._path, *map(_argument, words)],
                check=False,
                capture_output=True,
                text=True,
                stdin=subprocess.DEVNULL,
                timeout=_TIMEOUT_S,
                env=dict(os.environ),
            )
        except subprocess.TimeoutExpired as error:
            raise OSError(f"tmux {words[0]}: no answer") from error


def _literal(text: str) -> str:
    """Return a text so that tmux does not expand it: `#(command)` would run the command."""
    return text.replace("#", "##")


def _argument(word: str) -> str:
    """Return a word so that tmux does not take a semicolon at its end as the end of a command."""
    return f"{word[:-1]}\\;" if word.endswith(";") else word
