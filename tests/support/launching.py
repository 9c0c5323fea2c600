"""Files of the launcher, and `rosbase up` on them, with every process that comes of it."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from support.command import Lines
from support.processes import Token, bearers_of_a_token
from support.waiting import wait_until

__all__ = ["Up", "has_tmux", "own_tmux", "up"]


class Up:
    """A launcher that runs: `rosbase up`, or a script."""

    def __init__(self, command: list[str], folder: Path, environment: Mapping[str, str]) -> None:
        self.process = subprocess.Popen(
            command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env={**os.environ, **environment},
        )
        assert self.process.stdout is not None
        self.lines = Lines(self.process.stdout)

    @property
    def said(self) -> list[str]:
        """What it has written so far, with one blank wherever there are several."""
        return [" ".join(line.split()) for line in self.lines.lines]

    def waits_for(self, line: str) -> None:
        """Returns when it has written that line."""
        try:
            wait_until(lambda: line in self.said, line)
        except AssertionError as error:
            raise AssertionError(f"{error}, not only {self.said}") from None

    def send(self, signum: int) -> None:
        self.process.send_signal(signum)

    def end(self, signum: int | None = None) -> int:
        """Sends the signal, if there is one, and gives the exit status."""
        if signum is not None:
            self.send(signum)
        status = self.process.wait(40)
        self.lines.join()
        return status

    def close(self) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.end()
        assert self.process.stdout is not None
        self.process.stdout.close()


@contextmanager
def up(
    folder: Path,
    text: str,
    *options: str,
    name: str = "robot.toml",
    script: str = "",
    environment: Mapping[str, str] | None = None,
) -> Iterator[tuple[Up, Token]]:
    """Runs `rosbase up` on a file, in which TOKEN stands for a number of seconds to sleep.

    Whoever bears that token at the end is killed, whatever the test does.

    Args:
        folder: Where the file is written.
        text: What is in it.
        options: Those of the command.
        name: The file.
        script: A script that is run instead of the command.
        environment: What is added to that of the test.
    """
    with bearers_of_a_token() as token:
        (folder / name).write_text(text.replace("TOKEN", token.text))
        command = [sys.executable, "-m", "rosbase", "up", name, *options]
        if script:
            (folder / "launch.py").write_text(script)
            command = [sys.executable, "launch.py", *options]
        running = Up(command, folder, environment or {})
        try:
            yield running, token
        finally:
            running.close()


def has_tmux() -> bool:
    return shutil.which("tmux") is not None


class OwnTmux:
    """A tmux server of a test's own."""

    def __init__(self, folder: Path) -> None:
        self.environment = {"TMUX_TMPDIR": str(folder), "TMUX": "", "TERM": "xterm"}

    def __call__(self, *words: str) -> str:
        done = subprocess.run(
            ["tmux", *words],
            check=False,
            capture_output=True,
            text=True,
            env={**os.environ, **self.environment},
        )
        return done.stdout

    def panes(self, session: str) -> dict[str, str]:
        """For each pane its exit status, which is empty while it runs."""
        form = "#{pane_title}=#{pane_dead_status}"
        listed = self("list-panes", "-s", "-t", f"={session}", "-F", form)
        return dict(line.rpartition("=")[::2] for line in listed.splitlines())

    def waits_for(self, session: str, panes: dict[str, str]) -> None:
        """Returns when the session has these panes, with these statuses."""
        try:
            wait_until(lambda: self.panes(session) == panes, f"{panes}", 40)
        except AssertionError as error:
            texts = [self.text(session, number) for number in range(len(self.panes(session)))]
            raise AssertionError(f"{error}, not only {self.panes(session)} {texts}") from None

    def text(self, session: str, number: int) -> str:
        """What a pane shows, and what has been scrolled away."""
        return self("capture-pane", "-p", "-S", "-200", "-t", f"{session}:MAIN.{number}")

    def server(self) -> int:
        """The process of the server."""
        return int(self("display-message", "-p", "#{pid}"))


@contextmanager
def own_tmux(folder: Path) -> Iterator[OwnTmux]:
    """Gives a server, and ends it."""
    tmux = OwnTmux(folder)
    try:
        yield tmux
    finally:
        tmux("kill-server")
