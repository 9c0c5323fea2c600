"""Completion of the command line, in the shells themselves."""

import os
import pty
import select
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.command import ROSBASE
from support.operated import APP, Robots, robots_in, run
from support.waiting import wait_until

FOLDER = str(Path(ROSBASE).parent)


@pytest.fixture
def robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robots]:
    # A shell finds the command by its name.
    monkeypatch.setenv("PATH", f"{FOLDER}{os.pathsep}{os.environ['PATH']}")
    with robots_in(tmp_path, monkeypatch) as found:
        yield found


def candidates(*words: str) -> list[str]:
    """What the hidden command offers for the last word."""
    return [line.partition("\t")[0] for line in run("_complete", *words).splitlines()]


def test_commands_options_and_live_names_are_offered(robots: Robots) -> None:
    robots.start(APP)
    assert {"topic", "imu", "doctor", "ps"} <= set(candidates(""))
    assert candidates("lifec") == ["lifecycle"]
    assert candidates("param", "d") == ["describe", "dump"]
    assert candidates("param", "set", "--a") == ["--atomic"]
    assert candidates("doctor", "--js") == ["--json"]
    assert candidates("node", "info", "") == ["/app", "/arm"]
    assert candidates("node", "info", "a") == ["app", "arm"]
    assert candidates("param", "get", "app", "") == ["robot.names", "robot.speed"]
    assert candidates("param", "set", "app", "robot.speed", "") == []
    assert candidates("param", "set", "app", "robot.speed", "1", "robot.n") == ["robot.names"]
    assert candidates("lifecycle", "set", "arm", "") == ["configure", "shutdown"]
    assert candidates("log", "--level", "w") == ["warn"]
    assert candidates("log", "--level=w") == ["--level=warn"]
    assert candidates("ps", "-P", "") == ["app"]
    assert candidates("stop", "") == ["app"]
    assert candidates("completion", "") == ["bash", "zsh", "fish"]
    assert candidates("topic", "fly", "") == []
    assert candidates("nothing", "") == []
    assert candidates("--v") == ["--version"]


def test_files_are_offered(robots: Robots, tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").touch()
    (tmp_path / "robots").mkdir()
    begun = f"{tmp_path}/rob"
    for words in (["up"], ["run"], ["run", "app.py", "--params-file"], ["imu", "--params-file"]):
        assert candidates(*words, begun) == [f"{begun}ot.yaml", f"{begun}ots/"]
    assert candidates("param", "load", "app", begun) == [f"{begun}ot.yaml", f"{begun}ots/"]


def test_there_is_no_script_for_another_shell() -> None:
    assert "not for 'tcsh'" in run("completion", "tcsh", status=2)


def in_shell(name: str, script: str) -> list[str]:
    shell = shutil.which(name)
    if shell is None:
        pytest.skip(f"there is no {name}")
    options = {"bash": ["--norc"], "fish": ["--no-config"]}[name]
    done = subprocess.run(
        [shell, *options, "-c", script], capture_output=True, text=True, timeout=40, check=False
    )
    assert (done.returncode, done.stderr) == (0, ""), done
    return done.stdout.splitlines()


def test_bash_completes(robots: Robots) -> None:
    robots.start(APP)

    def complete(line: str) -> list[str]:
        words = " ".join(f"'{word}'" for word in line.split(" "))
        return in_shell(
            "bash",
            f'eval "$(rosbase completion bash)"\nCOMP_WORDS=({words})\n'
            'COMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n_rosbase\nprintf "%s\\n" "${COMPREPLY[@]}"',
        )

    assert complete("rosbase lifecycle s") == ["set"]
    assert complete("rosbase node info /a") == ["/app", "/arm"]
    assert complete("rosbase param get app robot.") == ["robot.names", "robot.speed"]
    assert in_shell("bash", 'eval "$(rosbase completion bash)"\ncomplete -p rosbase') == [
        "complete -F _rosbase rosbase"
    ]


def test_fish_completes(robots: Robots) -> None:
    robots.start(APP)

    def complete(line: str) -> list[str]:
        found = in_shell("fish", f"rosbase completion fish | source\ncomplete -C '{line}'")
        return [text.partition("\t")[0] for text in found]

    assert complete("rosbase lifecycle s") == ["set"]
    assert complete("rosbase node info /a") == ["/app", "/arm"]
    assert complete("rosbase param get app robot.") == ["robot.names", "robot.speed"]


class Shell:
    """An interactive zsh on a terminal of its own."""

    def __init__(self, folder: Path) -> None:
        shell = shutil.which("zsh")
        if shell is None:
            pytest.skip("there is no zsh")
        self._master, slave = pty.openpty()
        self._seen = ""
        self.process = subprocess.Popen(
            [shell, "-f", "-i"],
            stdin=slave,
            stdout=slave,
            stderr=slave,
            start_new_session=True,
            env={**os.environ, "ZDOTDIR": str(folder), "PS1": "> ", "TERM": "dumb"},
        )
        os.close(slave)

    def type(self, text: str) -> None:
        os.write(self._master, text.encode())

    def read_until(self, text: str) -> None:
        wait_until(lambda: self._shows(text), f"{text!r} on the terminal")
        self._seen = self._seen.partition(text)[2]

    def _shows(self, text: str) -> bool:
        if text not in self._seen and select.select([self._master], [], [], 0.05)[0]:
            self._seen += os.read(self._master, 4096).decode(errors="replace")
        return text in self._seen

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self._master)


def test_zsh_completes(robots: Robots, tmp_path: Path) -> None:
    robots.start(APP)
    shell = Shell(tmp_path)
    try:
        shell.type("autoload -U compinit; compinit -u -D; source <(rosbase completion zsh)\n")
        shell.type("print re''ady\n")
        shell.read_until("ready")
        shell.type("rosbase lifec\t")
        shell.read_until("rosbase lifecycle ")
        shell.type("g\t")
        shell.read_until("get ")
        shell.type("/ar\t")
        shell.read_until("/arm ")
        shell.type("\n")
        shell.read_until("unconfigured [1]")
    finally:
        shell.close()
