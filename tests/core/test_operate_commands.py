"""The commands for running programs, against programs that run."""

import json
import os
import signal
import socket
import subprocess
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from rosbase.control import connect
from rosbase.errors import ControlError
from support.command import ROSBASE, RunningRosbase
from support.control import FakeProgram, offering
from support.operated import APP, LISTENER, Robots, pid_of, robots_in, run, run_both
from support.stopwatch import Stopwatch
from support.waiting import wait_until


@pytest.fixture
def robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robots]:
    with robots_in(tmp_path, monkeypatch) as found:
        yield found


def test_ps_lists_programs_with_state_rate_and_memory(robots: Robots) -> None:
    app, listener = robots.start(APP), robots.start(LISTENER)
    head, *rows = run("ps").splitlines()
    assert " ".join(head.split()) == "PID PROGRAM KIND BACKEND STATE RATE TICKS OVERRUNS MEMORY UP"
    by_name = {row.split()[1]: row.split() for row in rows}
    assert by_name["app"][:7] == [
        str(pid_of(app)),
        "app",
        "manager",
        "local",
        "running",
        "100",
        "Hz",
    ]
    assert by_name["listener"][:5] == [
        str(pid_of(listener)),
        "listener",
        "node",
        "local",
        "running",
    ]
    found = json.loads(run("ps", "--json"))["processes"]
    assert {one["pid"] for one in found} == {pid_of(app), pid_of(listener)}
    assert all(one["memory_bytes"] > 1e6 for one in found)
    assert run("ps", "-P", "listener").count("\n") == 2


WAITING = """
from rosbase import BaseHandlers, BaseManager

class Handlers(BaseHandlers):
    def handle(self): ...

print("ready", flush=True)
manager = BaseManager("waits", {}, {}, Handlers, node_freq_hz=10)
manager.add_handshake_rule("camera", lambda: False)
manager.start_main_loop_timer()
"""


def test_ps_and_stop_work_on_a_program_that_waits_in_its_handshake(robots: Robots) -> None:
    program = robots.start(WAITING)
    wait_until(lambda: "waits" in run("ps"), "the program")
    assert "waits manager local waiting for camera 10 Hz 0 0 " in " ".join(run("ps").split())
    run("stop", "waits")
    program.end()


HANGS = """
import signal
import threading
from rosbase import BaseHandlers, BaseManager

may_go_on = threading.Event()
signal.signal(signal.SIGUSR1, lambda *_: may_go_on.set())

class Handlers(BaseHandlers):
    def handle(self):
        if self.timestamp == 3:
            may_go_on.wait()

print("ready", flush=True)
BaseManager("hangs", {}, {}, Handlers, node_freq_hz=50).start_main_loop_timer()
"""


def test_ps_and_stats_tell_that_a_loop_hangs(robots: Robots) -> None:
    program = robots.start(HANGS)
    wait_until(lambda: "running, in one tick for" in run("ps"), "the age of the tick")
    assert "the current tick has taken" in run("stats")
    program.process.send_signal(signal.SIGUSR1)
    wait_until(lambda: "in one tick" not in run("ps"), "the next ticks")
    assert "the current tick" not in run("stats")


def test_a_folder_of_sockets_with_wrong_rights_is_an_error_with_its_cure(robots: Robots) -> None:
    robots.start(APP)
    folder = Path(os.environ["XDG_RUNTIME_DIR"], "rosbase")
    folder.chmod(0o755)
    for words in ("ps", "topic list", "param get app robot.speed"):
        assert f"run `chmod 700 {folder}`" in run(*words.split(), status=1)
    folder.chmod(0o700)
    assert "app" in run("ps")


def test_nothing_runs_is_no_failure(robots: Robots) -> None:
    assert run("ps").count("\n") == 1
    for words in ("node list", "param list", "lifecycle nodes", "service list", "log"):
        assert run(*words.split()) == ""


def test_nodes_as_ros2_lists_them(robots: Robots) -> None:
    robots.start(APP)
    robots.start(LISTENER)
    assert run("node", "list") == "/app\n/arm\n/listener\n"
    assert run("node", "list", "-c") == "3\n"
    assert run("node", "list", "--program", "app") == "/app\n/arm\n"


def test_parameters_are_read_set_and_described_as_with_ros2(robots: Robots) -> None:
    robots.start(APP)
    assert run("param", "list", "app") == "  robot.names\n  robot.speed\n"
    assert run("param", "list") == "/app:\n  robot.names\n  robot.speed\n/arm:\n"
    assert run("param", "list", "app", "--param-type") == (
        "  robot.names (type: string array)\n  robot.speed (type: double)\n"
    )
    assert run("param", "get", "/app", "robot.speed") == "Double value is: 1.5\n"
    assert run("param", "get", "robot", "speed", "--hide-type") == "1.5\n"
    assert run("param", "get", "app", "robot.names") == "String values are: ['a', 'b']\n"
    assert run("param", "set", "app", "robot.speed", "2") == "Set parameter successful\n"
    assert run("param", "get", "app", "robot.speed") == "Double value is: 2.0\n"
    assert run("param", "describe", "app", "robot.speed") == (
        "Parameter name: robot.speed\n  Type: double\n  Constraints:\n"
    )


def test_the_key_of_a_plain_node_serves_to_list_save_and_load(
    robots: Robots, tmp_path: Path
) -> None:
    robots.start(APP)
    assert run("param", "list", "robot", "--param-type") == (
        "  names (type: string array)\n  speed (type: double)\n"
    )
    assert connect().parameter_names("robot") == {"robot": ["names", "speed"]}
    file = tmp_path / "robot.toml"
    file.write_text("[robot]\nspeed = 7\n")
    assert run("param", "load", "robot", str(file)) == "Set parameter speed successful\n"
    assert run("param", "get", "app", "robot.speed") == "Double value is: 7.0\n"
    assert run("param", "dump", "robot").startswith("/robot:\n  ros__parameters:\n    names:")


def test_a_key_in_several_programs_is_told_from_an_unknown_one(robots: Robots) -> None:
    robots.start(APP)
    other = robots.start(APP.replace('"app"', '"other"'))
    err = run("param", "get", "robot", "speed", status=1)
    assert "node robot is in 2 programs: " in err
    assert "choose one with --program" in err
    assert run("param", "get", "robot", "speed", "-P", "other") == "Double value is: 1.5\n"
    assert "did you mean robot?" in run("param", "get", "robt", "speed", status=1)
    other.process.terminate()
    other.end()


EVIL = """
from rosbase import BaseNode

node = BaseNode(node_name="evil")
node.declare_parameter("title", "\\x1b[2J")
node.create_timer(0.1, lambda: print("ready", flush=True))
node.start_spin_standalone()
"""


def test_a_value_does_no_harm_to_a_terminal(robots: Robots) -> None:
    robots.start(EVIL)
    assert run("param", "get", "evil", "title") == "String value is: \\x1b[2J\n"
    assert run("param", "get", "evil", "title", "--hide-type") == "\\x1b[2J\n"


def test_a_text_that_the_character_set_of_a_terminal_has_not_is_escaped(robots: Robots) -> None:
    robots.start(EVIL)
    run("param", "set", "evil", "title", "\u2603")
    done = subprocess.run(
        [ROSBASE, "param", "get", "evil", "title"],
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
        capture_output=True,
        text=True,
        timeout=40,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "String value is: \\u2603\n", "")


@pytest.mark.parametrize(
    ("closed", "err"),
    [(">&-", "rosbase: cannot write: stdout is closed\n"), ("2>&-", ""), (">&- 2>&-", "")],
)
def test_a_closed_stream_is_no_traceback(robots: Robots, closed: str, err: str) -> None:
    done = subprocess.run(
        f"'{ROSBASE}' param get no_such x {closed}",
        shell=True,
        capture_output=True,
        text=True,
        timeout=40,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (1, "", err)


def test_a_value_that_is_no_text_is_refused(robots: Robots) -> None:
    robots.start(EVIL)
    assert "not UTF-8" in run("param", "set", "evil", "title", "\udcff", status=2)


def test_a_parameter_that_is_not_set_is_told_and_status_1(robots: Robots) -> None:
    robots.start(APP)
    out, err = run_both("param", "set", "app", "robot.speed", "fast", status=1)
    assert out == ""
    assert err.startswith("Setting parameter failed: ")
    out, err = run_both("param", "set", "app", "robot.speed", "3", "robot.nmes", "[x]", status=1)
    assert out == "robot.speed: Set parameter successful\n"
    assert err.startswith("robot.nmes: Setting parameter failed: ")
    out, err = run_both(
        "param", "set", "--atomic", "app", "robot.speed", "4", "robot.nmes", "[x]", status=1
    )
    assert out == ""
    assert run("param", "get", "app", "robot.speed") == "Double value is: 3.0\n"
    assert "robot.nmes" in run("param", "get", "app", "robot.nmes", status=1)


def test_a_file_of_toml_is_loaded_and_its_mistakes_are_told(robots: Robots, tmp_path: Path) -> None:
    robots.start(APP)
    file = tmp_path / "app.toml"
    file.write_text("[robot]\nspeed = 7\n")
    assert run("param", "load", "app", str(file)) == "Set parameter robot.speed successful\n"
    assert run("param", "get", "app", "robot.speed") == "Double value is: 7.0\n"
    file.write_text('[robot]\nspeed = "fast"\n')
    assert "robot.speed" in run("param", "load", "app", str(file), status=1)
    assert "No such file" in run("param", "load", "app", "/no/such.toml", status=2)


def test_transitions_run_as_with_ros2(robots: Robots) -> None:
    robots.start(APP)
    assert run("lifecycle", "nodes") == "/arm\n"
    assert run("lifecycle", "get") == "/arm: unconfigured [1]\n"
    assert run("lifecycle", "get", "arm") == "unconfigured [1]\n"
    assert run("lifecycle", "list", "/arm") == (
        "- configure [1]\n\tStart: unconfigured\n\tGoal: configuring\n"
        "- shutdown [5]\n\tStart: unconfigured\n\tGoal: shuttingdown\n"
    )
    assert run("lifecycle", "set", "arm", "configure") == "Transitioning successful\n"
    assert run("lifecycle", "set", "arm", "3") == "Transitioning successful\n"
    assert run("lifecycle", "get", "arm") == "active [3]\n"


def test_a_transition_that_is_not_offered_is_refused_with_those_that_are(robots: Robots) -> None:
    robots.start(APP)
    err = run("lifecycle", "set", "arm", "activate", status=1)
    assert err.endswith(
        "Unknown transition requested, available ones are:\n- configure [1]\n- shutdown [5]\n"
    )


def test_the_log_of_all_programs_is_printed_in_the_format_of_ros(robots: Robots) -> None:
    robots.start(APP)
    lines = [line for line in run("log", "--level", "warn").splitlines() if "five ticks" in line]
    assert len(lines) == 1
    assert lines[0].startswith("[WARN] [")
    assert lines[0].endswith("] [app]: five ticks")
    assert run("log", "-n", "1").count("\n") == 1
    assert "not one of debug" in run("log", "-l", "loud", status=2)


def test_the_log_of_a_process_is_followed_until_its_end(robots: Robots) -> None:
    app = robots.start(APP)
    following = robots.start_command("log", "-f", "--level", "info", "-P", str(pid_of(app)))
    wait_until(
        lambda: following.stdout is not None and "five ticks" in following.stdout.readline(),
        "the record in memory",
    )
    run("lifecycle", "set", "arm", "configure")
    run("stop", "app")
    rest, _ = following.communicate(timeout=20)
    assert following.returncode == 0
    assert "]: configured the arm\n" in rest


@pytest.mark.parametrize("chosen", [[], ["-P", "app"]])
def test_the_log_of_programs_that_start_later_is_followed_too(
    robots: Robots, chosen: list[str]
) -> None:
    robots.start(APP)
    with RunningRosbase("log", "-f", "--level", "info", *chosen) as following:
        following.waits_for("five ticks", where=following.out)
        run("lifecycle", "set", "arm", "configure")
        following.waits_for("configured the arm", where=following.out)
        run("stop", "app")
        robots.start(APP)
        wait_until(lambda: following.out.count("five ticks") == 2, "the second program")
        run("lifecycle", "set", "arm", "configure")
        wait_until(lambda: following.out.count("configured the arm") == 2, "the second program")
        assert following.end(signal.SIGINT) == 130
        assert following.err.lines == []


def test_statistics_tell_ticks_and_times(robots: Robots) -> None:
    app = robots.start(APP)
    text = run("stats", "app")
    assert text.startswith(f"app [{pid_of(app)}]: ")
    assert " ticks at 100 Hz, " in text
    assert "\nperiod " in text
    assert "\nbusy " in text
    assert len(text.splitlines()) < 45
    assert json.loads(run("stats", "--json"))[0]["ticks"] > 5


def test_stop_ends_a_program_in_order(robots: Robots) -> None:
    app = robots.start(APP)
    assert run("stop", "app") == f"stopped app [{pid_of(app)}]\n"
    assert app.end()[0] == 0
    assert "no program app" in run("stop", "app", status=1)


def test_stop_says_when_a_program_does_not_end(robots: Robots) -> None:
    source = APP.replace(
        "manager.start_main", "manager.release_resources = wait\nmanager.start_main"
    )
    source = f"import time\n\n\ndef wait():\n    time.sleep(2)\n{source}"
    app = robots.start(source)
    err = run("stop", "app", "--timeout", "0.2", status=1)
    assert err == f"rosbase: app [{pid_of(app)}] still runs\n"
    assert app.end()[0] == 0


def test_stop_takes_a_pid(robots: Robots) -> None:
    app = robots.start(APP)
    run("stop", str(pid_of(app)))
    assert app.end()[0] == 0


def test_two_programs_of_one_name_are_told_apart_by_their_pids(robots: Robots) -> None:
    first, second = robots.start(APP), robots.start(APP)
    pids = sorted([pid_of(first), pid_of(second)])
    err = run("stop", "app", status=1)
    assert f"2 programs are named app: app [{pids[0]}], app [{pids[1]}]" in err
    err = run("param", "get", "app", "robot.speed", status=1)
    assert "node /app is in 2 programs" in err
    assert "--program" in err
    assert run("param", "get", "app", "robot.speed", "-P", str(pids[1])).endswith("1.5\n")


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ("param get ap robot.speed", "no node ap; did you mean /app?"),
        ("node info rbot", "no node rbot"),
        ("lifecycle get am", "no lifecycle node am; did you mean /arm?"),
        ("stop appp", "no program appp; did you mean app?"),
        ("restart app", "no program of rosbase up app; there is no program of rosbase up at all"),
        ("ps -P 999999999", "no program 999999999 runs"),
        ("ps -P lisener", "no program lisener"),
    ],
)
def test_an_unknown_name_is_told_with_what_was_meant(robots: Robots, words: str, text: str) -> None:
    robots.start(APP)
    assert text in run(*words.split(), status=1)


def test_the_reason_is_told_if_there_are_no_names_at_all(robots: Robots) -> None:
    assert run("stop", "app", status=1) == "rosbase: no program app; no program runs\n"
    assert run("topic", "info", "x", status=1) == "rosbase: no topic x; no program runs\n"
    assert run("node", "info", "x", status=1) == "rosbase: no node x; no program runs\n"
    assert run("ps", "-P", "app", status=1) == "rosbase: no program app; no program runs\n"
    app = robots.start(APP)
    app.process.send_signal(signal.SIGSTOP)
    try:
        for words in (["stop", "app"], ["topic", "info", "position"], ["node", "info", "app"]):
            err = run(*words, status=1)
            assert err.endswith(" among the programs that answer\n")
            assert f"process {pid_of(app)} does not answer\n" in err
    finally:
        app.process.send_signal(signal.SIGCONT)


@pytest.mark.parametrize(
    "words", ["topic", "topic fly", "param set app x", "ps --fast", "log -n x"]
)
def test_a_wrong_command_line_is_one_line_and_status_2(robots: Robots, words: str) -> None:
    assert run(*words.split(), status=2).count("\n") == 1


def test_a_program_that_does_not_answer_costs_a_second_and_is_named_once(robots: Robots) -> None:
    robots.start(APP)
    other = robots.start(LISTENER)
    os.kill(pid_of(other), signal.SIGSTOP)
    try:
        for words in ("node list", "topic echo position --once", "param get robot speed"):
            with Stopwatch() as watch:
                out, err = run_both(*words.split())
                assert watch.took_s < 5.0
            assert out
            assert err == f"rosbase: process {pid_of(other)} does not answer\n"
    finally:
        os.kill(pid_of(other), signal.SIGCONT)
    assert run("node", "list") == "/app\n/arm\n/listener\n"


def test_a_stale_socket_is_removed_and_not_spoken_of(robots: Robots) -> None:
    folder = Path(os.environ["XDG_RUNTIME_DIR"], "rosbase")
    folder.mkdir(mode=0o700)
    stale = folder / "999999999.sock"
    with socket.socket(socket.AF_UNIX) as left:
        left.bind(str(stale))
    assert run("node", "list") == ""
    assert not stale.exists()


def test_a_program_that_was_killed_is_not_spoken_of(robots: Robots) -> None:
    app = robots.start(APP)
    app.process.kill()
    app.end()
    assert run("node", "list") == ""


@pytest.mark.parametrize("noise", [b"", b"hello\n", b'{"protocol": 2}\n', b"\xff" * 100])
def test_something_else_that_listens_there_is_named(robots: Robots, noise: bytes) -> None:
    folder = Path(os.environ["XDG_RUNTIME_DIR"], "rosbase")
    folder.mkdir(mode=0o700)
    with socket.socket(socket.AF_UNIX) as other:
        other.bind(str(folder / f"{os.getpid()}.sock"))
        other.listen()
        command = robots.start_command("node", "list")
        connection, _ = other.accept()
        with connection:
            connection.sendall(noise)
            out, err = command.communicate(timeout=20)
    assert (command.returncode, out) == (0, "")
    assert str(os.getpid()) in err
    assert err.count("\n") == 1


def test_head_ends_a_command_quietly(robots: Robots) -> None:
    robots.start(APP)
    reading, writing = os.pipe()
    command = subprocess.Popen(
        [ROSBASE, "log", "-f"], stdout=writing, stderr=subprocess.PIPE, text=True
    )
    os.close(writing)
    with command:
        assert os.read(reading, 10)
        os.close(reading)
        # It notices with the next record.
        run("lifecycle", "set", "arm", "configure")
        _, err = command.communicate(timeout=20)
    assert (command.returncode, err) == (0, "")


def test_ctrl_c_ends_a_command_with_status_130_and_no_traceback(robots: Robots) -> None:
    robots.start(APP)
    command = robots.start_command("log", "-f")
    assert command.stdout is not None
    assert command.stdout.readline()
    command.send_signal(signal.SIGINT)
    _, err = command.communicate(timeout=20)
    assert (command.returncode, err) == (130, "")


def test_the_python_api_answers_what_the_commands_print(robots: Robots) -> None:
    app = robots.start(APP)
    with connect() as fleet:
        assert [p["pid"] for p in fleet.processes()] == [pid_of(app)]
        assert [n["name"] for n in fleet.nodes() if n["key"] != "robot"] == ["/app", "/arm"]
        assert fleet.get_parameters("app", ["robot.speed"]) == {"robot.speed": 1.5}
        result = fleet.set_parameters("app", {"robot.speed": 2.5, "robot.names": ["x"]})
        assert all(one["successful"] for one in result.values())
        assert fleet.get_parameters("robot") == {"names": ["x"], "speed": 2.5}
        assert fleet.describe_parameters("app", ["robot.speed"])["robot.speed"]["type"] == "double"
        assert fleet.change_state("arm", "configure")["successful"]
        assert fleet.lifecycle_state("arm")["state"] == "inactive"
        assert "cleanup" in [t["label"] for t in fleet.transitions("arm")]
        assert fleet.statistics()[0]["ticks"] > 0
        assert any(record["text"] == "five ticks" for record in fleet.log(level=30))
        with pytest.raises(ControlError) as caught:
            fleet.change_state("arm", "configure")
        assert caught.value.kind == "refused"
        fleet.stop("app")
    assert app.end()[0] == 0


def test_connect_to_a_program_that_does_not_run_raises(robots: Robots) -> None:
    robots.start(APP)
    connect("app")
    with pytest.raises(ControlError, match="did you mean app") as caught:
        connect("ap")
    assert (caught.value.kind, caught.value.suggestions) == ("unknown", ["app"])


def test_any_thread_may_ask(robots: Robots) -> None:
    app = robots.start(APP)
    fleet = connect()
    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda _: fleet.get_parameters("robot"), range(40)))
        pids = list(pool.map(lambda _: [p["pid"] for p in fleet.processes()], range(40)))
    assert answers == [{"names": ["a", "b"], "speed": 1.5}] * 40
    assert pids == [[pid_of(app)]] * 40


def test_what_rosbase_up_has_started_is_listed_stopped_and_restarted(robots: Robots) -> None:
    robots.start(APP)
    asked: list[tuple[str, str]] = []

    def answer(ask: str) -> Any:
        def take(_: Any, request: Any) -> dict[str, Any]:
            asked.append((ask, request.text("name")))
            return {}

        return take

    camera = {
        "name": "camera", "pid": 4712, "state": "running", "restarts": 2, "since_ns": 1,
        "required": True, "exit_status": None,
    }  # fmt: skip
    answers = {
        "launcher.list": lambda _, __: {"programs": [camera]},
        "launcher.stop": answer("stop"),
        "launcher.restart": answer("restart"),
    }
    with offering(FakeProgram(**answers)):
        shown = run("ps")
        assert " fake  " in shown
        assert shown.endswith(
            "started by rosbase up:\n PID  NAME    STATE    RESTARTS  REQUIRED  EXIT\n"
            "4712  camera  running         2  yes       -\n"
        )
        assert run("stop", "camera") == "stopped camera\n"
        assert run("restart", "camera") == "restarted camera\n"
        assert "no program of rosbase up camra; did you mean camera?" in run(
            "restart", "camra", status=1
        )
        assert run("_complete", "restart", "") == "camera\trunning\n"
        # A program of the same launcher that has no such name is one of its own.
        assert run("stop", "app").startswith("stopped app [")
    assert asked == [("stop", "camera"), ("restart", "camera")]
