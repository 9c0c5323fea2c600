"""`rosbase view --web`: what it says when it cannot show anything."""

from pathlib import Path

import pytest

from rosbase_view.web.server import bind
from support.operated import robots_in, run_both


def test_a_port_in_use_is_one_line() -> None:
    with bind("127.0.0.1", 0) as taken:
        port = str(taken.getsockname()[1])
        out, err = run_both("view", "--web", port, status=2)
    assert out == ""
    assert err.splitlines() == [
        f"rosbase: cannot listen on 127.0.0.1 port {port}: Address already in use"
    ]


def test_a_token_that_can_be_guessed_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROSBASE_VIEW_TOKEN", "1234")
    err = run_both("view", "--web", status=2)[1]
    assert err.count("\n") == 1
    assert "ROSBASE_VIEW_TOKEN needs 16 to 128 characters" in err


def test_a_program_that_does_not_run_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with robots_in(tmp_path, monkeypatch):
        err = run_both("view", "--web", "0", "nobody", status=1)[1]
    assert err.count("\n") == 1
    assert "nobody" in err
