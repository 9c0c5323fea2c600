"""The server of the control socket: who may come, and what no client can do to the program."""

import errno
import json
import os
import resource
import signal
import socket
import stat
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from rosbase import ControlError
from rosbase.control import clients, programs
from rosbase.control.clients import MOST_CLIENTS
from rosbase.control.gathering import gather
from rosbase.control.programs import offered
from rosbase.control.requests import Request
from rosbase.control.session import Session
from rosbase.control.streams import Stream
from rosbase.logger import RosbaseLogger
from support.control import Asker, Endless, FakeProgram, offering, own_socket
from support.waiting import wait_until


@pytest.fixture(autouse=True)
def own_folder(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Keeps the sockets of a test apart from those of all other programs of the user."""
    # Not in a folder of pytest's: the path of a socket is short.
    with tempfile.TemporaryDirectory(prefix="rosbase-server-") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        # Otherwise a client looks in the folder under /tmp too.
        monkeypatch.setenv("ROSBASE_CONTROL_FOLDER", f"{folder}/rosbase")
        yield


@pytest.fixture
def path() -> Iterator[str]:
    with offering() as found:
        yield found


def memory_bytes() -> int:
    """Memory of this process."""
    pages = Path("/proc/self/statm").read_text().split()[1]
    return int(pages) * resource.getpagesize()


def is_cut_off(client: Asker, data: bytes, times: int) -> bool:
    """Whether the other side, some time, takes no more."""
    try:
        for _ in range(times):
            client.socket.sendall(data)
    except OSError:
        return True
    return False


# Coming and going.


def test_a_client_is_greeted(path: str) -> None:
    with Asker(path) as client:
        assert client.hello["protocol"] == 1
        assert client.hello["pid"] == os.getpid()
        assert client.hello["rosbase"]
        assert client.ask("process")["pid"] == os.getpid()


def test_the_socket_is_there_while_a_program_runs_and_no_longer() -> None:
    threads = set(threading.enumerate())
    with offering() as first:
        with offering() as second:
            assert first == second
        with Asker(first) as client:
            assert client.hello
        (thread,) = set(threading.enumerate()) - threads
        assert (thread.name, thread.daemon) == ("control", True)
    assert not Path(first).exists()
    assert set(threading.enumerate()) == threads
    assert os.listdir(Path(first).parent) == []


def test_the_file_is_for_its_owner_only(path: str) -> None:
    for umask in (0o000, 0o077):
        before = os.umask(umask)
        try:
            with offering() as again:
                found = os.lstat(again)
        finally:
            os.umask(before)
        assert stat.S_ISSOCK(found.st_mode)
        assert stat.S_IMODE(found.st_mode) == 0o600
    assert stat.S_IMODE(os.lstat(Path(path).parent).st_mode) == 0o700


def test_without_a_folder_there_is_one_warning_with_a_cure_and_the_program_runs(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    (tmp_path / "rosbase").symlink_to("/nowhere")
    monkeypatch.delenv("ROSBASE_CONTROL_FOLDER")
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with offered(FakeProgram(), RosbaseLogger("robot")):
        assert programs._server is None
    with pytest.raises(KeyError), offered(FakeProgram(), RosbaseLogger("robot")):
        raise KeyError
    lines = [record.getMessage() for record in caplog.records]
    assert len(lines) == 2
    assert "is a symbolic link" in lines[0]
    assert "set XDG_RUNTIME_DIR" in lines[0]
    assert "ROSBASE_CONTROL=off" in lines[0]


FAILING = ["os.pipe", "selectors.DefaultSelector", "threading.Thread.start"]


@pytest.mark.parametrize("failing", FAILING)
def test_a_start_that_fails_halfway_leaves_nothing(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, failing: str
) -> None:
    def fail(*_: object) -> None:
        if failing.endswith("start"):
            raise RuntimeError("can't start new thread")
        raise OSError(errno.EMFILE, "Too many open files")

    monkeypatch.setattr(failing, fail)
    with offered(FakeProgram(), RosbaseLogger("robot")):
        assert not Path(own_socket()).exists()
    assert "there is no control socket" in caplog.text


# Who may come.

AS_NOBODY = """
import os, socket, sys
os.setgroups([])
os.setgid(65534)
os.setuid(65534)
connection = socket.socket(socket.AF_UNIX)
try:
    connection.connect(sys.argv[1])
except OSError as error:
    print(type(error).__name__)
else:
    print(connection.recv(1000).decode())
"""


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become another user")
def test_another_user_cannot_connect(path: str) -> None:
    command = [sys.executable, "-c", AS_NOBODY, path]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "PermissionError"


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become another user")
def test_another_user_who_gets_at_the_file_all_the_same_is_refused(
    path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    # As if somebody had opened the folder and the file to all.
    folder = Path(path).parent
    for one, rights in ((folder.parent, 0o711), (folder, 0o711), (Path(path), 0o666)):
        one.chmod(rights)
    try:
        command = [sys.executable, "-c", AS_NOBODY, path]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    finally:
        folder.parent.chmod(0o700)
        folder.chmod(0o700)
    said = json.loads(done.stdout)
    assert said == {"id": None, "error": "this socket belongs to another user", "kind": "refused"}
    with Asker(path) as client:
        assert client.ask("process")["clients"] == 1


@pytest.mark.parametrize(("ours", "may"), [(0, True), (1, False)])
def test_the_user_of_the_other_side_decides(
    monkeypatch: pytest.MonkeyPatch, ours: int, may: bool
) -> None:
    uid = os.geteuid()
    here, there = socket.socketpair()
    with here, there:
        if uid == 0 and ours:
            # Root may connect to everybody's.
            monkeypatch.setattr("struct.unpack", lambda *_: (1, 1_000, 1_000))
        else:
            monkeypatch.setattr("os.geteuid", lambda: uid + ours)
        assert clients.may_connect(here) is may


# What is left of others.


def left_behind(path: str) -> None:
    """Leaves a socket as a process does that is killed."""
    os.makedirs(Path(path).parent, mode=0o700, exist_ok=True)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(path)
        listener.listen()


def test_a_socket_of_an_earlier_process_with_this_pid_is_replaced() -> None:
    left_behind(own_socket())
    with offering() as path, Asker(path) as client:
        assert client.hello["pid"] == os.getpid()


def test_a_socket_of_a_living_process_of_another_container_is_left_alone() -> None:
    os.makedirs(Path(own_socket()).parent, mode=0o700, exist_ok=True)
    with socket.socket(socket.AF_UNIX) as other:
        other.bind(own_socket())
        other.listen()
        with offering() as path:
            second = path.replace(".sock", "-1.sock")
            with Asker(second) as client:
                assert client.hello["pid"] == os.getpid()
        assert os.listdir(Path(path).parent) == [Path(path).name]
    os.unlink(path)


def gone_pid() -> int:
    """The pid of a process that has ended."""
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    return process.pid


def test_stale_sockets_of_others_are_removed_and_nothing_else_is() -> None:
    folder, pid = Path(own_socket()).parent, gone_pid()
    # The last one is of a process that was killed before it had its name.
    names = [f"{pid}.sock", f"{pid}-1.sock", f"{pid}.0a1b2c"]
    for name in names:
        left_behind(str(folder / name))
    # A file of that name is nobody's socket, and this one's process lives.
    kept = [f"{gone_pid()}.sock", "notes.txt"]
    for name in kept:
        (folder / name).touch()
    left_behind(str(folder / f"{os.getppid()}.sock"))
    with offering():
        wait_until(
            lambda: not any((folder / name).exists() for name in names), "the stale sockets' end"
        )
        for name in [*kept, f"{os.getppid()}.sock"]:
            assert (folder / name).exists(), name
            (folder / name).unlink()


def test_a_client_that_looks_while_a_program_starts_takes_nothing_from_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looks: list[int] = []

    class Watched(socket.socket):
        """A socket during whose making a client looks at every step."""

        def bind(self, address: Any) -> None:
            super().bind(address)
            self.look()

        def listen(self, backlog: int = 0, /) -> None:
            self.look()
            super().listen(backlog)
            self.look()

        def look(self) -> None:
            looks.append(len(gather([("process", {})], on_silent=None)))

    os.makedirs(Path(own_socket()).parent, mode=0o700, exist_ok=True)
    monkeypatch.setattr(socket, "socket", Watched)
    with offering() as path:
        assert len(looks) == 3
        with Asker(path) as client:
            assert client.hello["pid"] == os.getpid()
        assert os.listdir(Path(path).parent) == [Path(path).name]


def test_a_start_that_fails_takes_its_unfinished_socket_along(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("os.rename", fail)
    with offering() as path:
        assert os.listdir(Path(path).parent) == []


def test_a_client_removes_no_socket_of_a_living_process() -> None:
    path = Path(own_socket()).parent / f"{os.getppid()}.sock"
    left_behind(str(path))
    assert gather([("process", {})]) == []
    # A process of that pid could be taking the name at this moment.
    assert path.exists()
    path.unlink()


def test_the_end_removes_its_own_socket_only() -> None:
    with offering() as path:
        os.unlink(path)
        left_behind(path)
    assert Path(path).exists()
    os.unlink(path)


def test_a_folder_that_somebody_removes_ends_nothing(path: str) -> None:
    os.unlink(path)
    os.rmdir(Path(path).parent)


# What a client may send.


def test_a_request_that_nobody_knows_is_named_with_what_may_be_meant(path: str) -> None:
    with Asker(path) as client:
        answer = client.answer("proces")
        assert answer["kind"] == "unknown"
        assert answer["suggestions"] == ["process"]
        assert client.ask("process")


@pytest.mark.parametrize(
    "line",
    [
        b"{}",
        b'{"id":1}',
        b'{"ask":"process"}',
        b'{"id":"1","ask":"process"}',
        b'{"id":true,"ask":"process"}',
        b'{"id":1.0,"ask":"process"}',
        b'{"id":99999999999999999999,"ask":"process"}',
        b'{"id":1,"ask":null}',
    ],
)
def test_a_request_without_id_or_name_is_an_error_and_the_next_one_counts(
    path: str, line: bytes
) -> None:
    with Asker(path) as client:
        client.socket.sendall(line + b"\n")
        frame, _ = client.read()
        assert (frame["id"], frame["kind"]) == (None, "invalid")
        assert client.ask("process")


@pytest.mark.parametrize("garbage", [b"\xff\xfe\n", b"GET / HTTP/1.1\r\n", b"[]\n", b"null\n"])
def test_garbage_ends_its_connection_with_an_error(path: str, garbage: bytes) -> None:
    with Asker(path) as client, Asker(path) as other:
        client.socket.sendall(garbage)
        frame, _ = client.read()
        assert (frame["id"], frame["kind"]) == (None, "invalid")
        assert client.is_closed()
        assert other.ask("process")["clients"] == 1


def test_half_requests_wait_and_cost_nothing(path: str) -> None:
    half = b'{"id":1,"ask":"process"'
    with Asker(path) as client, Asker(path) as other:
        client.socket.sendall(half)
        assert other.ask("process")["clients"] == 2
        client.socket.sendall(b"}\n")
        assert client.read()[0]["ok"]["clients"] == 2
        client.socket.sendall(half)
    with Asker(path) as third:
        wait_until(lambda: third.ask("process")["clients"] == 1, "the end of the others")


def test_a_line_of_100_mb_is_given_up_after_64_kib(path: str) -> None:
    before = memory_bytes()
    with Asker(path) as client:
        assert is_cut_off(client, b"x" * 1_000_000, times=100)
        assert client.is_closed()
    assert memory_bytes() - before < 20_000_000


def test_payloads_that_never_come_whole_are_bounded_for_all_connections_together(
    path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clients, "_MOST_HELD", 1_000_000)
    head = b'{"id":1,"ask":"process","bytes":60000000}\n'
    askers = [Asker(path) for _ in range(3)]
    try:
        for asker in askers[:2]:
            asker.socket.sendall(head + b"x" * 400_000)
        askers[2].socket.sendall(head)
        assert is_cut_off(askers[2], b"x" * 100_000, times=100)
    finally:
        for asker in askers:
            asker.close()


def test_many_requests_at_once_are_all_answered_in_order(path: str) -> None:
    with Asker(path) as client:
        count = 500
        line = b"".join(
            json.dumps({"id": n, "ask": "nothing"}).encode() + b"\n" for n in range(count)
        )
        client.socket.sendall(line)
        assert [client.read()[0]["id"] for _ in range(count)] == list(range(count))


def test_a_client_that_reads_no_answers_is_not_read_from(path: str) -> None:
    before = memory_bytes()
    with Asker(path) as client:
        client.socket.settimeout(0.5)
        assert is_cut_off(client, b'{"id":1,"ask":"process"}\n' * 1_000, times=1_000)
    assert memory_bytes() - before < 50_000_000


def test_a_thousand_connections_are_served_or_told_why_not(
    path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clients, "_REST_NS", 10**12)
    connections, told = [], 0
    try:
        for _ in range(1_000):
            connection = socket.socket(socket.AF_UNIX)
            connections.append(connection)
            connection.settimeout(20)
            connection.connect(path)
            frame = json.loads(connection.makefile("rb").readline())
            told += "error" in frame
            last = frame
    finally:
        for connection in connections:
            connection.close()
    assert told == 1_000 - MOST_CLIENTS
    assert last["error"] == f"64 clients are connected to process {os.getpid()}"
    wait_until(lambda: len_of_clients(path) == 1, "the end of the connections")


def test_idle_connections_make_room_for_others_and_busy_ones_do_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(clients, "_REST_NS", 0)
    program = FakeProgram(
        fed=lambda *_: Fed(), never=lambda _, request: request.wait(timeout_ns=10**12)
    )
    with ExitStack() as stack, offering(program) as path:
        busy = [stack.enter_context(Asker(path)) for _ in range(MOST_CLIENTS - 2)]
        for number, client in enumerate(busy):
            client.send("fed" if number % 2 else "never")
            if number % 2:
                client.read()
        first, second = (stack.enter_context(Asker(path)) for _ in range(2))
        assert first.ask("process")["clients"] == MOST_CLIENTS
        # The second has been silent for longer.
        with Asker(path) as other:
            assert other.ask("stop") == {"programs": ["/fake"]}
            frame = second.read()[0]
            assert (frame["id"], frame["kind"]) == (None, "refused")
            assert frame["error"].endswith("and this one rests")
            assert second.is_closed()
            assert first.ask("process")["clients"] == MOST_CLIENTS
            first.send("never")
            other.send("never")
            wait_until(lambda: len_of_clients(path) == 0, "all to be busy")


def len_of_clients(path: str) -> int:
    """The number of clients, this one included; 0 if there are too many."""
    try:
        with Asker(path) as client:
            return int(client.ask("process")["clients"])
    except (BrokenPipeError, ConnectionResetError):
        return 0


def test_when_descriptors_run_out_the_thread_rests_and_goes_on_later(
    path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    server: Any = programs._server
    with Asker(path) as before:
        before.ask("process")
        limits = resource.getrlimit(resource.RLIMIT_NOFILE)
        client = socket.socket(socket.AF_UNIX)
        client.settimeout(20)
        used = max(map(int, os.listdir("/proc/self/fd")))
        resource.setrlimit(resource.RLIMIT_NOFILE, (3, limits[1]))
        try:
            client.connect(path)
            wait_until(lambda: server._paused_until_ns is not None, "the rest")
            assert before.ask("process")["clients"] == 1
        finally:
            resource.setrlimit(resource.RLIMIT_NOFILE, limits)
        with client, client.makefile("rb") as answers:
            assert b"protocol" in answers.readline()
        assert used


# Streams.


def test_a_stream_is_taken_as_fast_as_the_client_reads_and_no_faster() -> None:
    stream = Endless(10_000)
    program = FakeProgram(flood=lambda session, request: stream)
    with offering(program) as path, Asker(path) as slow, Asker(path) as other:
        slow.send("flood")
        other.ask("process")
        taken = -1
        while taken != stream.taken:
            taken = stream.taken
            other.ask("process")
        # What the kernel holds, and what the session does.
        assert 0 < taken < 200
        assert slow.read()[0] == {"id": 1, "ok": {}}
        for number in range(1, 1_000):
            frame, data = slow.read()
            assert frame["event"] == {"n": number}
            assert len(data) == 10_000
        slow.send("cancel", of=1)
        while (frame := slow.read()[0]).get("id") != 2:
            assert frame["event"]
        assert frame == {"id": 2, "ok": {}}
        assert slow.read()[0] == {"id": 1, "end": "cancelled"}
        assert stream.is_closed
        assert other.answer("cancel", of=1)["kind"] == "unknown"


def test_a_client_that_goes_away_ends_its_streams() -> None:
    stream = Endless(1_000)
    with offering(FakeProgram(flood=lambda session, request: stream)) as path:
        with Asker(path) as client:
            client.ask("flood")
        wait_until(lambda: stream.is_closed, "the end of the stream")
        assert len_of_clients(path) == 1


class Fed(Stream):
    """Events that the test gives."""

    def __init__(self) -> None:
        self.ok = {}
        self.waiting: list[int] = []
        self.takes = 0
        self.is_closed = False

    def take(self) -> tuple[dict[str, Any], bytes] | None:
        self.takes += 1
        return ({"n": self.waiting.pop(0)}, b"") if self.waiting else None

    def close(self) -> None:
        self.is_closed = True


def test_a_stream_wakes_the_thread_and_ends_when_it_is_empty() -> None:
    stream = Fed()
    with offering(FakeProgram(fed=lambda session, request: stream)) as path, Asker(path) as client:
        client.ask("fed")
        for number in range(100):
            stream.waiting.append(number)
            stream.wake()
            assert client.read()[0]["event"] == {"n": number}
        stream.waiting.extend([1, 2])
        stream.end("enough")
        assert [client.read()[0] for _ in range(3)] == [
            {"id": 1, "event": {"n": 1}},
            {"id": 1, "event": {"n": 2}},
            {"id": 1, "end": "enough"},
        ]
        assert stream.is_closed


def test_a_stream_wakes_nobody_while_the_client_does_not_read() -> None:
    stream, other_stream = Endless(10_000), Fed()
    program = FakeProgram(flood=lambda *_: stream, fed=lambda *_: other_stream)
    server: Any
    with offering(program) as path, Asker(path) as slow, Asker(path) as other:
        slow.send("flood")
        slow.send("fed")
        server = programs._server
        taken = -1
        while taken != stream.taken:
            taken = stream.taken
            other.ask("process")
        takes = other_stream.takes
        for _ in range(100):
            other_stream.wake()
            stream.wake()
        assert not server._calls
        other.ask("process")
        assert other_stream.takes == takes
        other_stream.waiting.append(1)
        while (frame := slow.read()[0]) != {"id": 2, "event": {"n": 1}}:
            assert frame.get("id") == 1 or "ok" in frame


def test_a_stream_may_have_events_at_times_of_its_own() -> None:
    class Clockwork(Stream):
        def __init__(self, session: Session) -> None:
            self.ok = {}
            self.session = session
            self.due_ns = session.now_ns() + 10_000_000

        def take(self) -> tuple[dict[str, Any], bytes] | None:
            assert self.due_ns is not None
            if self.session.now_ns() < self.due_ns:
                return None
            self.due_ns += 10_000_000
            return {"due": self.due_ns}, b""

    program = FakeProgram(clockwork=lambda session, request: Clockwork(session))
    with offering(program) as path, Asker(path) as client:
        client.ask("clockwork")
        dues = [client.read()[0]["event"]["due"] for _ in range(10)]
        assert dues == list(range(dues[0], dues[0] + 100_000_000, 10_000_000))


def test_an_exception_of_a_stream_ends_it_and_is_logged(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class Broken(Fed):
        def take(self) -> tuple[dict[str, Any], bytes] | None:
            raise KeyError("lens")

    stream = Broken()
    with offering(FakeProgram(broken=lambda *_: stream)) as path, Asker(path) as client:
        client.ask("broken")
        assert client.read()[0] == {"id": 1, "end": "failed"}
        assert stream.is_closed
        assert client.ask("process")
    assert "a stream failed: KeyError('lens')" in caplog.text


def test_lost_events_are_counted_for_the_process() -> None:
    class Losing(Fed):
        dropped = 7

    with offering(FakeProgram(losing=lambda *_: Losing())) as path, Asker(path) as other:
        with Asker(path) as client:
            client.ask("losing")
            assert other.ask("process")["dropped"] == 7
        wait_until(lambda: other.ask("process")["clients"] == 1, "the end of the other")
        assert other.ask("process")["dropped"] == 7


# Answers.


def test_an_answer_may_come_later_from_any_thread_with_bytes() -> None:
    asked: list[Request] = []

    def later(_: Session, request: Request) -> Any:
        asked.append(request)
        return request.wait()

    with offering(FakeProgram(later=later)) as path, Asker(path) as client:
        number = client.send("later", b"question", x=5)
        wait_until(lambda: asked, "the request")
        assert asked[0].data == b"question"
        assert asked[0].whole("x") == 5
        assert client.ask("process")
        assert asked[0].answer({"y": 6}, b"answer")
        assert client.read() == ({"id": number, "ok": {"y": 6}, "bytes": 6}, b"answer")
        assert not asked[0].answer({"y": 7})
        assert not asked[0].fail(ControlError("late"))
        assert client.ask("process")


def test_a_client_that_asks_nothing_more_still_gets_its_late_answers() -> None:
    asked: list[Request] = []
    stream = Fed()

    def later(_: Session, request: Request) -> Any:
        asked.append(request)
        return request.wait()

    program = FakeProgram(later=later, fed=lambda *_: stream)
    with offering(program) as path, Asker(path) as client:
        number = client.send("later")
        client.ask("fed")
        # As `nc -N` does at the end of its input.
        client.socket.shutdown(socket.SHUT_WR)
        wait_until(lambda: asked, "the request")
        assert len_of_clients(path) == 2
        stream.waiting.append(5)
        stream.wake()
        assert client.read()[0]["event"] == {"n": 5}
        assert asked[0].answer({"y": 6})
        assert client.read()[0] == {"id": number, "ok": {"y": 6}}
        stream.end("done")
        assert client.read()[0]["end"] == "done"
        assert client.is_closed()


def test_a_client_that_asks_nothing_more_and_leaves_ends_its_streams() -> None:
    stream = Fed()
    with offering(FakeProgram(fed=lambda *_: stream)) as path:
        with Asker(path) as client:
            client.ask("fed")
            client.socket.shutdown(socket.SHUT_WR)
            assert len_of_clients(path) == 2
        wait_until(lambda: stream.is_closed, "the end of the stream")
        assert len_of_clients(path) == 1


def test_a_request_that_nobody_answers_times_out_when_it_says() -> None:
    gave_up = []

    def give_up() -> str:
        gave_up.append(True)
        return "nobody came"

    program = FakeProgram(never=lambda _, request: request.wait(give_up))
    with offering(program) as path, Asker(path) as client:
        answer = client.answer("never", timeout_ns=20_000_000)
        assert answer == {"id": 1, "error": "nobody came", "kind": "timeout"}
        assert gave_up == [True]
        assert client.answer("never", timeout_ns=-1)["kind"] == "invalid"
        assert client.answer("never", timeout_ns="soon")["kind"] == "invalid"


def test_an_exception_of_an_answer_is_an_error_and_is_logged_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    def fail(*_: object) -> Any:
        raise KeyError("lens")

    with offering(FakeProgram(fail=fail)) as path, Asker(path) as client:
        for number in (1, 2):
            assert client.answer("fail") == {
                "id": number,
                "error": "KeyError: 'lens'",
                "kind": "failed",
            }
    assert caplog.text.count("fail failed: KeyError('lens')") == 1


def test_an_exception_while_the_program_stops_is_an_error_and_is_not_logged(
    caplog: pytest.LogCaptureFixture,
) -> None:
    def fail(*_: object) -> Any:
        raise KeyError("lens\nand its\x1b[2J cap")

    program = FakeProgram(fail=fail)
    program.phase = "stopping"
    with offering(program) as path, Asker(path) as client:
        # One line, whatever is in it.
        assert client.answer("fail")["error"] == r"KeyError: 'lens\nand its\x1b[2J cap'"
    assert not caplog.records


def test_an_error_of_several_lines_is_told_in_one() -> None:
    def refuse(*_: object) -> Any:
        raise ControlError("one\n  two\x1b", "refused")

    with offering(FakeProgram(refuse=refuse)) as path, Asker(path) as client:
        assert client.answer("refuse")["error"] == "one two\\x1b"


def test_an_answer_that_is_no_json_is_an_error() -> None:
    with offering(FakeProgram(odd=lambda *_: {"x": object()})) as path, Asker(path) as client:
        assert "cannot be sent" in client.answer("odd")["error"]
        assert client.ask("process")


def test_an_id_cannot_be_open_twice_and_64_requests_are_the_most() -> None:
    program = FakeProgram(never=lambda _, request: request.wait())
    with offering(program) as path, Asker(path) as client:
        for _ in range(64):
            client.send("never")
        assert client.answer("process")["kind"] == "refused"
        client._number = 0
        assert client.answer("process")["kind"] == "invalid"


def test_the_end_of_the_program_is_told_to_those_who_wait() -> None:
    program = FakeProgram(
        never=lambda _, request: request.wait(), fed=lambda session, request: Fed()
    )
    with offering(program) as path:
        client = Asker(path)
        client.send("never")
        client.send("fed")
        assert client.read()[0] == {"id": 2, "ok": {}}
    with client:
        ends = [client.read()[0] for _ in range(2)]
        assert {"id": 1, "error": "the program ends", "kind": "refused"} in ends
        assert {"id": 2, "end": "the program ends"} in ends
        assert client.is_closed()


def test_what_a_connection_holds_is_released_with_it() -> None:
    released = []

    def hold(session: Session, _: Request) -> dict[str, Any]:
        session.kept["thing"] = 5
        session.on_close(lambda: released.append(session.kept["thing"]))
        session.on_close(lambda: released[9])
        session.on_close(lambda: released.append(6))
        return {}

    with offering(FakeProgram(hold=hold)) as path:
        with Asker(path) as client:
            client.ask("hold")
        wait_until(lambda: released == [5, 6], "the release")


def test_our_answers_come_before_those_of_programs(path: str) -> None:
    program = FakeProgram(process=lambda *_: {"mine": 1}, other=lambda *_: {"mine": 2})
    with offering(program), Asker(path) as client:
        assert client.ask("process")["pid"] == os.getpid()
        assert client.ask("other") == {"mine": 2}


# Forks.

# Python warns of a fork in a process with threads, from 3.12 on.
ignore_forks = pytest.mark.filterwarnings("ignore:This process .* is multi-threaded")


@ignore_forks
def test_a_forked_child_keeps_nothing_and_may_have_a_socket_of_its_own(path: str) -> None:
    with Asker(path) as client:
        client.ask("process")
        read_fd, write_fd = os.pipe()
        pid = os.fork()
        if pid == 0:
            try:
                links = []
                for fd in os.listdir("/proc/self/fd"):
                    try:
                        links.append(os.readlink(f"/proc/self/fd/{fd}"))
                    except OSError:
                        continue
                # The client's end is the child's as well; the server's three are not.
                found = [f"{sum('eventpoll' in one for one in links)} {programs._programs}"]
                client.close()
                found.append(str(sum("socket" in one for one in links)))
                with offering() as own:
                    found.append(str(Asker(own).ask("process")["pid"] == os.getpid()))
                found.append(str(Path(path).exists()))
                os.write(write_fd, "|".join(found).encode())
            finally:
                os._exit(0)
        os.close(write_fd)
        with open(read_fd) as answer:
            said = answer.read().split("|")
        os.waitpid(pid, 0)
        assert said[0] == "0 ()"
        assert said[2:] == ["True", "True"]
        assert client.ask("process")["clients"] == 1
    # Whoever connects is closed when the parent closes, whatever children there are.


@ignore_forks
def test_a_connection_ends_with_the_program_although_a_forked_child_lives() -> None:
    with offering() as path:
        client = Asker(path)
        client.ask("process")
        pid = os.fork()
        if pid == 0:
            client.close()
            signal.pause()
    try:
        with client:
            assert client.is_closed()
    finally:
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)


OWN_DESCRIPTORS = """
import os
for name in os.listdir("/proc/self/fd"):
    try:
        print(os.readlink(f"/proc/self/fd/{name}"))
    except OSError:
        pass
"""


def test_a_subprocess_inherits_nothing(path: str) -> None:
    with Asker(path) as client:
        client.ask("process")
        command = [sys.executable, "-c", OWN_DESCRIPTORS]
        done = subprocess.run(command, capture_output=True, text=True, check=True, close_fds=False)
        assert "socket" not in done.stdout
        assert "eventpoll" not in done.stdout
