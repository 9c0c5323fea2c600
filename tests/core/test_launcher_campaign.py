"""Programs up and down again, with SIGKILL at random moments: nothing is ever left.

`nox -s launcher` does it with fifty programs, twenty times.
"""

import os
import random
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from rosbase.control.folder import sockets
from rosbase.processes.proc import everybody, parent_in, read_of
from support.launching import Up, up
from support.processes import Token, state_of
from support.waiting import wait_until

RUNS = int(os.environ.get("ROSBASE_LAUNCHER_RUNS", "3"))
PROGRAMS = int(os.environ.get("ROSBASE_LAUNCHER_PROGRAMS", "5"))

KINDS = (
    "exec sleep TOKEN",
    "setsid sleep TOKEN & sleep TOKEN",
    "trap '' INT; sleep TOKEN & exec sleep TOKEN",
    "(sleep TOKEN &) ; sleep 0.3; exit 1",
    "rosbase run node.py TOKEN",
)
NODE = """
from rosbase import BaseHandlers, BaseManager
BaseManager("node", handlers_class=BaseHandlers, node_freq_hz=10).start_main_loop_timer()
"""


def text(number: int) -> str:
    """A file with so many programs of all kinds; one in ten is a program of rosbase."""
    parts = []
    for n in range(number):
        command = KINDS[4 if n % 10 == 4 else n % 4]
        after = f'after = "p{n // 2}"' if n % 3 == 2 else ""
        parts.append(
            f'[[nodes]]\nname = "p{n}"\ncommand = "{command}"\n{after}\n'
            'restart = { policy = "on-failure", backoff_s = 0.05, limit = 1000 }\n'
        )
    return "".join(parts)


@contextmanager
def running(folder: Path) -> Iterator[tuple[Up, Token]]:
    (folder / "node.py").write_text(NODE)
    with up(folder, text(PROGRAMS)) as (launcher, token):
        yield launcher, token


@pytest.fixture
def own_sockets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setenv("ROSBASE_CONTROL_FOLDER", str(tmp_path / "rosbase"))


@pytest.mark.timeout(120 * RUNS)
@pytest.mark.usefixtures("own_sockets")
def test_whatever_is_killed_at_random_moments_leaves_nothing(tmp_path: Path) -> None:
    chance = random.Random(18)
    for _ in range(RUNS):
        # The launcher itself, while it starts, runs or stops.
        with running(tmp_path) as (launcher, token):
            wait_until(lambda: len(token.sleepers()) >= chance.randint(0, PROGRAMS), "some")
            if chance.random() < 0.3:
                launcher.send(signal.SIGINT)
            # It may be killed before it takes signals, or be done already.
            assert launcher.end(signal.SIGKILL) in (-signal.SIGKILL, -signal.SIGINT, 0)
            token.wait_until_gone()
        # Its programs and guardians, and then a stop in order.
        with running(tmp_path) as (launcher, token):
            wait_until(lambda: len(token.sleepers()) >= PROGRAMS // 2, "half of them")
            for _ in range(PROGRAMS):
                _kill_one(chance, launcher, token)
            wait_until(lambda: not _zombies(launcher), "no zombie")
            assert launcher.end(signal.SIGINT) in (0, 1)
            assert not token.bearers(), launcher.said[-200:]
    # A program that was killed has left its socket, and the next start removes it.
    with up(tmp_path, '[[nodes]]\nname = "last"\ncommand = "sleep 0.5"\n') as (launcher, _):
        assert launcher.end() == 0
    assert not sockets()


def _kill_one(chance: random.Random, launcher: Up, token: Token) -> None:
    victims = sorted(set(token.bearers()) - {launcher.process.pid})
    if victims:
        try:
            os.kill(chance.choice(victims), signal.SIGKILL)
        except ProcessLookupError:
            # It has ended meanwhile.
            pass


def _zombies(launcher: Up) -> list[int]:
    return [
        pid
        for pid, stat in everybody().items()
        if parent_in(stat) == launcher.process.pid
        and state_of(pid) == "Z"
        and not read_of(pid, "cmdline")
    ]
