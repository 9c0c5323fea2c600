"""What comes over the link of a node: records are limited, and what cannot be read ends it."""

import logging
from pathlib import Path

import pytest

from rosbase.processes.records import RecordLines
from support.program import running

APP = """
import os, pickle, re, signal, stat, struct, sys, time
from pathlib import Path
from rosbase import (BaseHandlers, BaseManager, BaseNode, RestartPolicy,
                     register_multiprocess_nodes)
from rosbase.messages import Header

class Hostile:
    def __init__(self, call):
        self.call = call
    def __reduce__(self):
        return self.call

def send(data):
    (link,) = [n for n in range(3, 64) if is_socket(n)]
    while data:
        data = data[os.write(link, data):]

def is_socket(number):
    try:
        return stat.S_ISSOCK(os.fstat(number).st_mode)
    except OSError:
        return False

def framed(data):
    return struct.pack("!i", len(data)) + data

class Node(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.create_timer(0.01, self.once)
        self.is_done = False
    def once(self):
        if not self.is_done:
            self.is_done = True
            WHAT

class Handlers(BaseHandlers):
    def handle(self):
        if (not processes["x"].is_alive and "again" not in sys.argv) or self.timestamp > 1000:
            self.manager.request_stop()

if __name__ == "__main__":
    processes = register_multiprocess_nodes({"x": Node}, {}, OPTIONS)
    manager = BaseManager(handlers_class=Handlers)
    manager.start_main_loop_timer(processes)
    # The peak of this program; what getrusage gives begins with that of whoever started it.
    status = Path("/proc/self/status").read_text()
    print(re.search(r"VmHWM:[^0-9]+([0-9]+)", status)[1])
"""


def run(folder: Path, what: str, options: str = "", *arguments: str) -> tuple[int, str, str]:
    app = APP.replace("WHAT", what).replace("OPTIONS", options)
    # So that the link is the only socket of the child.
    with running(folder, app, *arguments, env={"ROSBASE_CONTROL": "off"}) as program:
        status, out, err = program.end()
        assert not program.family()
    # Before there is a manager, another logger writes.
    return status, out, err.replace("[processes]", "[BaseManager]")


@pytest.mark.parametrize(
    ("junk", "why"),
    [
        ("b'hello, world\\n' * 10", "it announces a message of more than 268435456 bytes"),
        ("struct.pack('!i', 2**31 - 1)", "it announces a message of more than 268435456 bytes"),
        ("struct.pack('!iQ', -1, 2**63)", "it announces a message of more than 268435456 bytes"),
        ("struct.pack('!i', -7)", "what it sends cannot be read: EOFError"),
        ("framed(b'')", "what it sends cannot be read: EOFError"),
        ("framed(os.urandom(1000))", "what it sends cannot be read: "),
        ("framed(pickle.dumps(('record', 20, 'x'))[:-3])", "what it sends cannot be read: "),
        ("framed(pickle.dumps(42))", "what it sends cannot be read: TypeError"),
        ("framed(pickle.dumps(('explode', 1)))", "what it sends cannot be read: KeyError"),
        ("framed(pickle.dumps((['record'], 1)))", "what it sends cannot be read: TypeError"),
        ("framed(pickle.dumps(('record', 'x')))", "what it sends cannot be read: TypeError"),
        ("framed(pickle.dumps(('record', 'x', 20)))", "what it sends cannot be read: TypeError"),
        ("framed(pickle.dumps(('want', 5, int, 0, None)))", "cannot be read: TypeError"),
        ("framed(pickle.dumps(('want', '/a', Header, 0, 'deep')))", "cannot be read: TypeError"),
        ("framed(b'cno_such_module\\nThing\\n.')", "cannot be read: ModuleNotFoundError"),
        ("framed(pickle.dumps(Hostile((sys.exit, (3,)))))", "cannot be read: SystemExit: 3"),
        ("framed(pickle.dumps(Hostile((int, ('x',)))))", "cannot be read: ValueError"),
        ("framed(b'(' * 3_000_000)", "what it sends cannot be read: "),
    ],
)
def test_junk_on_its_link_is_an_error_in_the_log_and_ends_the_child(
    tmp_path: Path, junk: str, why: str
) -> None:
    status, out, err = run(tmp_path, f"send({junk})")
    assert status == 0, err
    assert int(out) < 200_000, "kB of memory"
    (line,) = [line for line in err.splitlines() if "it is stopped" in line]
    assert line.startswith("[ERROR] [BaseManager]: x: ")
    assert why in line
    assert "[ERROR] [BaseManager]: x: ended with status 0" in err
    assert "Traceback" not in err


def test_a_child_that_ends_in_the_middle_of_a_message_has_just_ended(tmp_path: Path) -> None:
    what = "send(struct.pack('!i', 1000) + b'x' * 10); os.kill(os.getpid(), signal.SIGKILL)"
    status, _, err = run(tmp_path, what)
    assert status == 0
    assert "it is stopped" not in err
    assert "x: was ended by SIGKILL" in err


def test_a_child_that_sent_junk_has_failed_and_is_started_again_if_its_policy_says_so(
    tmp_path: Path,
) -> None:
    options = "restart=RestartPolicy('on-failure', limit=1, first_delay_s=0.01), required=True"
    status, _, err = run(tmp_path, "send(framed(b'x'))", options, "again")
    assert status == 1, err
    assert err.count("it is stopped") == 2
    assert "x: not started again: 1 in a row" in err


def test_a_child_that_ignores_its_stop_after_junk_is_killed(tmp_path: Path) -> None:
    deaf = "signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})"
    status, _, err = run(tmp_path, f"{deaf}; send(framed(b'x')); time.sleep(1000)")
    assert status == 0, err
    assert "x: had to be killed" in err


def test_a_node_that_floods_the_log_is_limited_and_its_errors_are_not_lost(
    tmp_path: Path,
) -> None:
    what = (
        "[self.logger.info(f'line {n}') for n in range(20_000)]; self.logger.error('bad end');"
        " self._request_stop()"
    )
    status, _, err = run(tmp_path, what)
    assert status == 0, err
    lines = err.splitlines()
    assert len(lines) < 3000
    assert "[ERROR] [BaseManager]: x: bad end" in err
    assert any("more lines" in line for line in lines)


def test_a_record_of_a_node_that_is_too_long_is_cut(tmp_path: Path) -> None:
    # It does not stop by itself: what waits to be sent has little time then.
    status, out, err = run(tmp_path, "self.logger.info('a' * 20_000_000)")
    assert status == 0, err
    assert int(out) < 400_000
    assert f"[INFO] [BaseManager]: x: {'a' * 4096} ... " in err
    assert len(err) < 10_000


def test_the_lines_of_a_record_are_lines_of_the_log_each_with_level_and_name(
    tmp_path: Path,
) -> None:
    what = (
        "self.logger.error('bad', exc_info=ValueError('lens'));"
        " self.logger.warning('one\\ntwo'); self._request_stop()"
    )
    _, _, err = run(tmp_path, what)
    for line in (
        "[ERROR] [BaseManager]: x: bad",
        "[ERROR] [BaseManager]: x:   ValueError: lens",
        "[WARN] [BaseManager]: x: one\\ntwo",
    ):
        assert line in err.splitlines()


INFO, ERROR = logging.INFO, logging.ERROR


def test_records_that_are_too_many_in_a_second_are_counted() -> None:
    records = RecordLines(max_lines_per_s=2)
    said = [list(records.take(INFO, text, 0)) for text in ("a", "b", "c\nd", "e")]
    assert said == [[(INFO, "a")], [(INFO, "b")], [], []]
    assert list(records.take(INFO, "f", 999_999_999)) == []
    assert list(records.take(INFO, "g", 1_000_000_000)) == [
        (INFO, "... 4 more lines"),
        (INFO, "g"),
    ]
    assert list(records.finish()) == []


def test_errors_have_lines_of_their_own() -> None:
    records = RecordLines(max_lines_per_s=1)
    said = [list(records.take(level, "x", 0)) for level in (INFO, INFO, ERROR, ERROR)]
    assert said == [[(INFO, "x")], [], [(ERROR, "x")], []]
    assert list(records.finish()) == [(INFO, "... 1 more lines"), (ERROR, "... 1 more lines")]


def test_long_lines_and_long_records_are_cut() -> None:
    records = RecordLines(max_line=4)
    assert list(records.take(INFO, "abcdef\nok", 0)) == [
        (INFO, "abcd ... 2 more characters"),
        (INFO, "ok"),
    ]
    *lines, (_, last) = RecordLines().take(INFO, "x\n" * 100_000, 0)
    assert len(lines) <= 500
    assert last == "x"
