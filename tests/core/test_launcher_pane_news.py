"""News that the launcher writes into the pane of a program."""

import os
import select
from collections.abc import Iterator
from pathlib import Path
from typing import cast

import pytest

from rosbase.clock import SystemClock
from rosbase.launcher.tmux.client import Pane, Tmux
from rosbase.launcher.tmux.panes import Panes


@pytest.fixture
def terminals() -> Iterator[list[tuple[int, str]]]:
    """Two terminals: the descriptor that shows what is written, and the path."""
    pairs = [os.openpty() for _ in range(2)]
    yield [(shown, os.ttyname(written)) for shown, written in pairs]
    for pair in pairs:
        for fd in pair:
            os.close(fd)


def shown_on(fd: int) -> bytes:
    """Without what the terminal makes of the ends of lines."""
    return os.read(fd, 100).strip() if select.select([fd], [], [], 0)[0] else b""


def test_news_go_to_the_terminal_of_the_pane_and_to_no_later_one_of_its_path(
    tmp_path: Path, terminals: list[tuple[int, str]]
) -> None:
    (shown, path), (shown_later, path_later) = terminals
    panes = Panes(cast(Tmux, None), tmp_path, SystemClock(), {})
    panes._note("a", Pane("%1", path))
    panes.write("a", "news")
    assert shown_on(shown) == b"news"
    # The pane runs its script again on another terminal.
    panes._note("a", Pane("%1", path_later))
    panes.write("a", "more")
    assert (shown_on(shown), shown_on(shown_later)) == (b"", b"more")
    # The path is that of a terminal that was made at another time.
    panes._made_ns["a"] -= 1
    panes.write("a", "to nobody")
    assert shown_on(shown_later) == b""
    panes.close()
