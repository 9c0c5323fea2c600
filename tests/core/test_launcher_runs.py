"""`rosbase up` with real processes: order, ends, signals, CPUs, what a program is given."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from support.launching import up
from support.processes import state_of
from support.stopwatch import Stopwatch
from support.waiting import wait_until

SLEEPERS = """
[[nodes]]
name = "a"
command = "echo here; exec sleep TOKEN"
[[nodes]]
name = "b"
command = "exec sleep TOKEN"
[[nodes]]
name = "c"
command = "exec sleep TOKEN"
"""


def order_of(lines: list[str], word: str) -> list[str]:
    """The names of the programs of which that was said, in its order."""
    return [line.split()[0] for line in lines if line.split()[1:3] == ["*", word]]


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_stops_all_in_reverse_order_and_is_no_failure(
    tmp_path: Path, signum: signal.Signals
) -> None:
    with up(tmp_path, SLEEPERS) as (launcher, token):
        token.wait_for_sleepers(3)
        launcher.waits_for("a | here")
        assert launcher.end(signum) == 0
        assert not token.bearers()
    assert order_of(launcher.said, "starting") == ["a", "b", "c"]
    assert order_of(launcher.said, "stopping") == ["c", "b", "a"]
    assert order_of(launcher.said, "was") == ["c", "b", "a"]


THREE = """
[[nodes]]
name = "third"
command = "sleep 0.3; exit 7"
required = true
after = "second"
restart = { policy = "on-failure", limit = 1, backoff_s = 0.05 }
[[nodes]]
name = "second"
command = "echo $PPID; exec sleep TOKEN"
after = { first = "log: ready [0-9]" }
[[nodes]]
name = "first"
command = "echo ready soon; sleep 0.2; echo ready 1; exec sleep TOKEN"
"""


def test_three_programs_start_in_their_order_and_end_with_the_status_of_the_required_one(
    tmp_path: Path,
) -> None:
    with up(tmp_path, THREE) as (launcher, token):
        assert launcher.end() == 7
        assert not token.bearers()
    said = launcher.said
    assert order_of(said, "starting") == ["first", "second", "third", "third"]
    assert said.index("first | ready 1") < said.index("second * starting")
    assert "second * waiting for first: log: ready [0-9]" in said
    assert said.count("third * ended with status 7") == 2
    assert order_of(said, "is") == ["third"]
    assert order_of(said, "stopping") == ["second", "first"]


def test_a_second_signal_ends_all_at_once(tmp_path: Path) -> None:
    script = """
import signal, sys, time
from rosbase import BaseLauncher
from rosbase.runtime.stopping import wishes

# Two that follow each other closely count as one.
wishes.SAME_WISH_NS = 0
BaseLauncher("robot.toml").launch()
"""
    # It takes all the time that a stop may take: four seconds.
    slow = """
[[nodes]]
name = "a"
command = '''exec python -c "
import signal, time
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, lambda *_: None)
print('deaf', flush=True)
while True:
    time.sleep(TOKEN)
"'''
"""
    with up(tmp_path, slow, script=script) as (launcher, token):
        launcher.waits_for("a | deaf")
        launcher.send(signal.SIGINT)
        launcher.waits_for("a * stopping")
        with Stopwatch() as watch:
            assert launcher.end(signal.SIGINT) == 0
            assert not token.bearers()
            # SIGINT and SIGTERM have 0.4 s each now, and not two seconds and one.
            assert watch.took_s < 2.0


@pytest.mark.parametrize(
    ("limit", "how"), [("0.2", "was ended by SIGTERM"), ("20", "ended with status 0")]
)
def test_a_program_has_its_own_time_to_stop(tmp_path: Path, limit: str, how: str) -> None:
    text = f"""
[[nodes]]
name = "a"
stop_timeout_s = {limit}
command = '''exec {sys.executable} -c "
import os, signal, sys, time
def park(*_):
    print('parking', flush=True)
    time.sleep(3)
    sys.exit()
signal.signal(signal.SIGINT, park)
print(os.environ.get('ROSBASE_STOP_S'), flush=True)
signal.pause()
"'''
"""
    with up(tmp_path, text) as (launcher, _):
        launcher.waits_for("a | None")
        assert launcher.end(signal.SIGINT) == 0
    assert "a | parking" in launcher.said
    assert f"a * {how}" in launcher.said


@pytest.mark.parametrize("command", ["{ sleep TOKEN & } ; sleep TOKEN", "setsid sleep TOKEN"])
def test_nothing_survives_a_launcher_that_is_killed(tmp_path: Path, command: str) -> None:
    text = f'[[nodes]]\nname = "a"\ncommand = "{command} & sleep TOKEN"\n'
    with up(tmp_path, text) as (launcher, token):
        wait_until(lambda: len(token.sleepers()) >= 2, "two sleepers")
        assert launcher.end(signal.SIGKILL) == -signal.SIGKILL
        token.wait_until_gone()


def test_all_processes_of_a_program_are_pinned_and_no_others(tmp_path: Path) -> None:
    last = max(os.sched_getaffinity(0))
    text = f"""
[[nodes]]
name = "pinned"
cpus = "{last}"
command = ["sleep 0", "sleep TOKEN & sleep TOKEN"]
[[nodes]]
name = "free"
command = "exec sleep TOKEN"
"""
    with up(tmp_path, text) as (launcher, token):
        token.wait_for_sleepers(3)
        # The shell of the second program has become a sleeper.
        shown = {pid: _taskset(pid) for pid in token.bearers()}
        pinned = [pid for pid, cpus in shown.items() if cpus == str(last)]
        # The guardian, its shell, and what the shell has started.
        assert len(pinned) == 4
        assert _taskset(launcher.process.pid) == _taskset(os.getpid())
        assert launcher.end(signal.SIGINT) == 0


def _taskset(pid: int) -> str:
    done = subprocess.run(["taskset", "-cp", str(pid)], check=True, capture_output=True, text=True)
    return done.stdout.rpartition(": ")[2].strip()


def test_commands_of_a_list_run_one_after_another_in_one_shell(tmp_path: Path) -> None:
    text = """
[[nodes]]
name = "a"
command = ["X=1", "false", "cd /", "echo $X $PWD; (exit 3)"]
"""
    with up(tmp_path, text) as (launcher, _):
        assert launcher.end() == 1
    assert "a | 1 /" in launcher.said
    assert "a * ended with status 3" in launcher.said


def test_a_plain_command_takes_the_place_of_its_shell_and_others_need_it(tmp_path: Path) -> None:
    text = r"""
[[nodes]]
name = "program"
command = "sleep TOKEN"
[[nodes]]
name = "last"
command = ["X=TOKEN", "ls / > /dev/null", "sleep $X"]
[[nodes]]
name = "builtin"
command = "eval 'echo $((6 * 7))'"
[[nodes]]
name = "function"
command = ["f() { echo \"$1\"; }", "f 'a  b'"]
[[nodes]]
name = "two"
command = "true && echo both"
[[nodes]]
name = "variable"
command = "A=1 printenv A"
"""
    with up(tmp_path, text) as (launcher, token):
        token.wait_for_sleepers(2)
        shells = [line for line in token.bearers().values() if "guardian" not in line]
        assert shells == [f"sleep {token.text}"] * 2
        for name, said in (("builtin", "42"), ("function", "a b"), ("two", "both")):
            launcher.waits_for(f"{name} | {said}")
        launcher.waits_for("variable | 1")
        assert launcher.end(signal.SIGINT) == 0


def test_a_stop_ends_a_list_of_commands(tmp_path: Path) -> None:
    first = "import signal, sys; signal.signal(2, lambda *_: sys.exit()); print('up', flush=True)"
    text = f"""
[[nodes]]
name = "a"
command = ['''{sys.executable} -c "{first}; signal.pause()"''', "echo went on"]
"""
    with up(tmp_path, text) as (launcher, _):
        launcher.waits_for("a | up")
        assert launcher.end(signal.SIGINT) == 0
    assert "a | went on" not in launcher.said
    assert "a * ended with status 0" in launcher.said


PROGRAM = """
import os, sys
from rosbase import BaseManager, BaseNode

class Camera(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.declare_parameter("fps", 10)
        print("fps", self.get_parameter("fps").value, os.environ["COLOUR"], flush=True)

manager = BaseManager("robot", {"camera": Camera})
print(type(manager.backend).__module__, flush=True)
manager.nodes["camera"].create_timer(0.01, manager.request_stop)
manager.start_main_loop_timer()
"""


def test_a_program_gets_its_parameters_its_backend_and_its_environment(tmp_path: Path) -> None:
    (tmp_path / "robot").mkdir()
    (tmp_path / "robot" / "app.py").write_text(PROGRAM)
    (tmp_path / "robot" / "fps.toml").write_text("[camera]\nfps = 60\n")
    text = f"""
[env]
workspace_root = "."
[[nodes]]
name = "values"
project = "robot"
command = "{sys.executable} app.py"
backend = "local"
[nodes.env]
COLOUR = "red"
[nodes.parameters.camera]
fps = 30
fsp = 1
[[nodes]]
name = "file"
project = "robot"
command = "rosbase run app.py"
parameters = "fps.toml"
env = {{ COLOUR = "blue" }}
[[nodes]]
name = "wrong"
project = "robot"
command = "rosbase run app.py"
backend = "nobody"
env = {{ COLOUR = "grey" }}
"""
    with up(tmp_path, text) as (launcher, _):
        assert launcher.end() == 1
    said = launcher.said
    assert "values | fps 30 red" in said
    assert "values | rosbase.local.backend" in said
    assert "file | fps 60 blue" in said
    assert any(line.startswith("wrong |") and "nobody" in line for line in said)
    # A parameter that nobody declares is named, although a launcher has started the program.
    assert any("no node declares the parameter camera.fsp" in line for line in said), said


def test_programs_that_end_in_order_end_the_launcher(tmp_path: Path) -> None:
    text = '[[nodes]]\nname = "a"\ncommand = "echo done"\n'
    with up(tmp_path, text) as (launcher, _):
        assert launcher.end() == 0
    assert launcher.said == ["a * starting", "a | done", "a * ended with status 0"]


def test_a_program_that_fails_without_being_required_leaves_the_others_alone(
    tmp_path: Path,
) -> None:
    text = SLEEPERS + '[[nodes]]\nname = "d"\ncommand = "exit 3"\n'
    with up(tmp_path, text) as (launcher, token):
        launcher.waits_for("d * ended with status 3")
        assert len(token.wait_for_sleepers(3)) == 3
        assert launcher.end(signal.SIGINT) == 0


def test_a_program_that_is_asked_to_stop_by_name_of_its_group_leaves_no_zombie(
    tmp_path: Path,
) -> None:
    with up(tmp_path, SLEEPERS) as (launcher, token):
        pids = token.wait_for_sleepers(3)
        for pid in pids:
            os.kill(pid, signal.SIGKILL)
        assert launcher.end() == 1
        assert [state_of(pid) for pid in pids] == ["", "", ""]


def test_output_can_not_forge_the_line_of_another_program(tmp_path: Path) -> None:
    text = """
[[nodes]]
name = "a"
command = "printf 'x\\rb      | forged\\\\033[2J\\n'"
[[nodes]]
name = "b_longer"
command = "true"
"""
    with up(tmp_path, text) as (launcher, _):
        assert launcher.end() == 0
    assert "a | x" in launcher.said
    assert not [line for line in launcher.said if line.startswith("b |")]
    assert all(line.isprintable() for line in launcher.lines.lines)


@pytest.mark.parametrize("option", [[], ["--check"]])
def test_a_file_with_mistakes_starts_nothing(tmp_path: Path, option: list[str]) -> None:
    text = """
[env]
workspace_root = "nowhere"
[[nodes]]
name = "a"
command = "touch started"
cpus = "0,4000"
[[nodes]]
name = "b"
command = "no_such_program --flag"
project = "/"
[[nodes]]
name = "c"
command = "python missing.py"
project = "/tmp"
parameters = "none.toml"
comand = 3
[[nodes]]
name = "d"
command = "./missing"
project = "/tmp"
"""
    with up(tmp_path, text, *option) as (launcher, _):
        assert launcher.end() == 2
    workspace = tmp_path / "nowhere"
    assert launcher.said == [
        f"robot.toml:3: workspace_root: no folder {workspace}",
        f"robot.toml:7: no CPU 4000 for 'a': this machine has {os.cpu_count()}",
        "robot.toml:10: command of 'b': there is no program no_such_program",
        "robot.toml:14: command of 'c': no file ./missing.py",
        "robot.toml:16: parameters: no file /tmp/none.toml",
        "robot.toml:17: program 'c' has no 'comand'; did you mean command?",
        "robot.toml:20: command of 'd': no file ./missing",
    ]
    assert not (tmp_path / "started").exists()


def test_a_program_without_a_control_socket_can_not_be_waited_for(tmp_path: Path) -> None:
    text = """
[[nodes]]
name = "a"
command = "true"
env = { ROSBASE_CONTROL = "off" }
[[nodes]]
name = "b"
command = "true"
after = { a = "handshake" }
"""
    with up(tmp_path, text) as (launcher, _):
        assert launcher.end() == 2
    fault = "after: ROSBASE_CONTROL is off for 'a', so it tells no handshake"
    assert launcher.said == [f"robot.toml:9: {fault}"]


HOPELESS = """
[env]
conda_env = "a\\u0000b"
[[nodes]]
name = "a"
command = "~nobody_at_all/x"
[nodes.env]
X = "LONG"
Y = "LONG"
"""


def test_a_check_names_mistakes_even_if_no_shell_can_be_asked(tmp_path: Path) -> None:
    # Together, the variables are more than a process can be given.
    text = HOPELESS + "".join(f'X{n} = "{"x" * 110_000}"\n' for n in range(30))
    with up(tmp_path, text, "--check") as (launcher, _):
        assert launcher.end() == 2
    assert launcher.said == [
        "robot.toml:3: conda_env has a NUL character",
        "robot.toml:6: command of 'a': no file ~nobody_at_all/x",
    ]
    text = text.replace("~nobody_at_all/x", "ls")
    with up(tmp_path, text, "--check") as (launcher, _):
        assert launcher.end() == 2
    assert any("the shell for the programs cannot start: " in line for line in launcher.said)
    with up(tmp_path, SLEEPERS, "--check", name="~nobody_at_all") as (launcher, _):
        assert launcher.end() == 2
    assert launcher.said == ["rosbase: there is no home folder ~nobody_at_all"]


def test_a_script_that_launches_something_else_is_told_so(tmp_path: Path) -> None:
    script = 'from rosbase import BaseLauncher\nBaseLauncher([{"nodes": []}]).launch()\n'
    with up(tmp_path, "", script=script) as (launcher, _):
        assert launcher.end() == 2
    assert launcher.said == ["a launch is the name of a file, or a mapping, not a list"]


def test_a_script_may_enable_one_program_by_its_name_alone(tmp_path: Path) -> None:
    script = (
        "from rosbase import BaseLauncher\n"
        'BaseLauncher("robot.toml", enable_nodes="b", disable_nodes="a").launch()\n'
    )
    text = """
[[nodes]]
name = "a"
command = "true"
[[nodes]]
name = "b"
command = "true"
autostart = false
"""
    with up(tmp_path, text, "--check", script=script) as (launcher, _):
        assert launcher.end() == 0
    assert launcher.said == ["robot.toml: no mistakes; 1 of 2 programs start: b"]


WORKING = [
    ["foo() { echo hi; }", "foo"],
    ["PATH=$PATH:$PWD/a", "made_later"],
    ["true", "made_later"],
    ["time -p ls"],
    ["exec -a me ls"],
    ["A+=1 true"],
    ["no_such_program || true"],
    ["cat <<END", "x", "END"],
    ["shopt -s extglob", "echo !(a|b)"],
    ["python -c pass made_later.py"],
]


@pytest.mark.parametrize("commands", WORKING)
def test_a_check_accepts_commands_that_work(tmp_path: Path, commands: list[str]) -> None:
    text = f'[[nodes]]\nname = "a"\ncommand = {json.dumps(commands)}\n'
    with up(tmp_path, text, "--check") as (launcher, _):
        assert launcher.end() == 0, launcher.said


BUILT = """
[[nodes]]
name = "build"
command = "printf 'echo built' > gen.sh; chmod +x gen.sh; echo 'print(6 * 7)' > gen.py"
[[nodes]]
name = "a"
command = "./gen.sh"
after = { build = "exit 0" }
[[nodes]]
name = "b"
command = "python gen.py"
after = { build = "exit 0" }
"""


def test_a_program_may_run_what_another_one_has_built(tmp_path: Path) -> None:
    with up(tmp_path, BUILT) as (launcher, _):
        assert launcher.end() == 0, launcher.said
    assert {"a | built", "b | 42"} <= set(launcher.said)


@pytest.mark.parametrize(
    ("command", "fault"),
    [
        ("./plain.txt", "./plain.txt is not executable"),
        ("./folder", "./folder is a folder"),
        ("python -u missing.py", "no file ./missing.py"),
        ("rosbase run missing.py --flag", "no file ./missing.py"),
        ("bash missing.sh", "no file ./missing.sh"),
        ("python folder.py", "folder.py is a folder"),
        ("A+=1 no_such_program", "there is no program no_such_program"),
        ("if true; then", "syntax error: unexpected end of file"),
        ("echo 'unclosed", "unexpected EOF while looking for matching `''"),
    ],
)
def test_a_check_finds_commands_that_can_not_work(tmp_path: Path, command: str, fault: str) -> None:
    (tmp_path / "plain.txt").touch()
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder.py").mkdir()
    text = f'[[nodes]]\nname = "a"\ncommand = {json.dumps(command)}\n'
    with up(tmp_path, text, "--check") as (launcher, _):
        assert launcher.end() == 2
    [said] = launcher.said
    assert said.startswith("robot.toml:3: command of 'a': ")
    assert fault.removeprefix("./") in said


def test_a_broken_parameter_file_is_named_with_all_other_mistakes(tmp_path: Path) -> None:
    (tmp_path / "broken.toml").write_text("x = [")
    text = '[[nodes]]\nname = "a"\ncommand = "no_such_program"\nparameters = "broken.toml"\n'
    with up(tmp_path, text, "--check") as (launcher, _):
        assert launcher.end() == 2
    assert [line.split(": ")[:2] for line in launcher.said] == [
        ["robot.toml:3", "command of 'a'"],
        ["robot.toml:4", "parameters"],
    ]


def test_a_byte_that_is_no_text_is_named_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "latin.toml").write_bytes(b"[[nodes]]\nname = '\xe9'\n")
    script = 'from rosbase import BaseLauncher\nBaseLauncher("latin.toml").launch()\n'
    with up(tmp_path, "", script=script) as (launcher, _):
        assert launcher.end() == 2
    assert launcher.said[0].startswith("latin.toml:2: ")


def test_a_pattern_is_looked_for_at_the_beginning_of_a_line_only(tmp_path: Path) -> None:
    text = """
[[nodes]]
name = "a"
command = "printf '%03000dready\\n' 0"
[[nodes]]
name = "b"
command = "true"
after = { a = "log: ready$" }
"""
    with up(tmp_path, text) as (launcher, _):
        assert launcher.end() == 1
    text = "b * cannot start: a has ended, and it waits for a: log: ready$"
    assert text in launcher.said


def test_all_mistakes_are_named_at_once_with_those_of_the_options(tmp_path: Path) -> None:
    text = '[[nodes]]\nname = "a"\ncommand = "true"\ncpus = "0-99999"\n'
    with up(tmp_path, text, "--enable", "b") as (launcher, _):
        assert launcher.end() == 2
    cpus, enable = launcher.said
    assert cpus.startswith("robot.toml:4: no CPU ")
    assert "..., for" not in cpus
    assert ", ... for 'a': this machine has" in cpus
    assert enable == "no program is called 'b'; there are a"


def test_the_setup_of_ros_is_sourced_in_the_workspace(tmp_path: Path) -> None:
    (tmp_path / "work/a").mkdir(parents=True)
    (tmp_path / "setup.sh").write_text("setup_pwd=$PWD\n")
    text = """
[env]
workspace_root = "work"
ros_setup = "setup.sh"
[[nodes]]
name = "a"
project = "a"
command = "echo $setup_pwd $PWD"
"""
    with up(tmp_path, text) as (launcher, _):
        assert launcher.end() == 0
    assert f"a | {tmp_path}/work {tmp_path}/work/a" in launcher.said


def test_a_launch_of_nothing_is_a_mistake(tmp_path: Path) -> None:
    with up(tmp_path, SLEEPERS, "--disable", "a", "b", "c") as (launcher, _):
        assert launcher.end() == 2
    assert launcher.said == ["rosbase: no program starts: none is enabled"]


def test_a_file_without_mistakes_is_praised_and_nothing_starts(tmp_path: Path) -> None:
    options = ["--check", "--disable", "b", "--enable", "b", "c"]
    with up(tmp_path, SLEEPERS, *options) as (launcher, token):
        assert launcher.end() == 0
        assert not token.bearers()
    assert launcher.said == ["robot.toml: no mistakes; 2 of 3 programs start: a, c"]


def test_a_file_that_is_not_here_is_looked_for_beside_the_script(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "robot.toml").write_text('[[nodes]]\nname = "a"\ncommand = "pwd"\n')
    script = tmp_path / "launch.py"
    script.write_text("from rosbase import BaseLauncher\nBaseLauncher('robot.toml').launch()\n")

    def launch() -> str:
        done = subprocess.run(
            [sys.executable, str(script)],
            cwd=tmp_path / "elsewhere",
            check=True,
            capture_output=True,
            text=True,
        )
        return done.stdout

    assert f"a | {tmp_path}\n" in launch()
    (tmp_path / "elsewhere" / "robot.toml").write_text(
        '[[nodes]]\nname = "near"\ncommand = "pwd"\n'
    )
    assert f"near | {tmp_path / 'elsewhere'}\n" in launch()


SCRIPT = """
import sys
from rosbase import BaseLauncher

config = {"nodes": [{"name": n, "command": "echo x", "autostart": n == "a"} for n in "abc"]}
BaseLauncher(config, enable_nodes=["b", "c"], disable_nodes=["c"]).launch()
print("launched")
"""


def test_a_script_enables_and_disables_and_so_does_its_command_line(tmp_path: Path) -> None:
    with up(tmp_path, "", script=SCRIPT) as (launcher, _):
        assert launcher.end() == 0
    assert sorted(order_of(launcher.said, "starting")) == ["a", "b"]
    assert launcher.said[-1] == "launched"
    with up(tmp_path, "", "--disable", "a", script=SCRIPT) as (launcher, _):
        assert launcher.end() == 0
    assert order_of(launcher.said, "starting") == ["b"]
    with up(tmp_path, "", "--disable", "x", script=SCRIPT) as (launcher, _):
        assert launcher.end() == 2
    assert launcher.said == ["no program is called 'x'; there are a, b, c"]


def test_yaml_without_pyyaml_names_the_command_that_installs_it(tmp_path: Path) -> None:
    script = """
import sys
sys.modules["yaml"] = None
from rosbase import BaseLauncher
BaseLauncher("robot.yaml").launch()
"""
    with up(tmp_path, "nodes: []", name="robot.yaml", script=script) as (launcher, _):
        assert launcher.end() == 2
    assert launcher.said == ["robot.yaml: YAML needs PyYAML: pip install pyyaml"]
