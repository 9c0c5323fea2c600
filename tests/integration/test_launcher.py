"""Files as programs of ros_base have them, and panes of tmux, with real processes."""

import os
import re
import signal
import sys
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import get_args

import pytest
import yaml
from hypothesis import given

from rosbase.control import connect
from rosbase.launcher.description import Description, Faults, read_mapping, read_text
from rosbase.launcher.description.model import ConditionKind
from rosbase.launcher.description.programs import PROGRAM_KEYS, RESTART_KEYS
from rosbase.launcher.description.sessions import ENV_KEYS
from rosbase.launcher.tmux.client import session_size
from rosbase.processes.proc import read_of
from support.code_blocks import BLOCKS, ROOT, write_files
from support.command import ROSBASE
from support.launching import OwnTmux, has_tmux, own_tmux, up
from support.processes import parent_of
from support.strategies import launcher_data
from support.terminal import on_terminal
from support.waiting import wait_until

needs_tmux = pytest.mark.skipif(not has_tmux(), reason="tmux is not installed")

SESSIONS = """\
sessions:                       # or one session at the root, without this list
  - env:
      session_name: "demo_system"
      workspace_root: "~/work"          # every project is below it
      ros_setup: "~/ros_ws/setup.sh"    # optional: sourced first
      conda_env: "robot"                # optional: activated next
    nodes:
      - name: "LOW_LEVEL"
        project: "controller"           # may be "." or a/b
        cpus: "CPU"                     # optional: "7", "4-5", "0,2"; taskset
        autostart: true                 # the default
        command: "python run.py"        # a text, or a list typed one after another
      - name: "VISION"
        project: "a/b"
        command: ["ROBOT=blue", "echo vision $ROBOT $ROS_DISTRO $CONDA_DEFAULT_ENV $PWD"]
      - name: "ALL"
        project: "."
        autostart: false
        command: "echo never"
"""
# The same without the list.
AT_THE_ROOT = "\n".join(line[4:] for line in SESSIONS.splitlines()[1:]) + "\n"
SCRIPT = 'from rosbase import BaseLauncher\nBaseLauncher("robot.yaml").launch()\n'

# As the real one, it prints a function that changes the environment of the shell.
CONDA = """\
#!/bin/sh
if [ "$1 $2" = "shell.posix hook" ]; then
  cat <<END
conda() {
  [ "\\$1" = activate ] && [ "\\$2" = robot ] || { echo "no environment \\$2" >&2; return 1; }
  export CONDA_DEFAULT_ENV=\\$2
}
END
fi
"""
RUN = """\
import os, time
print("low", *(os.environ[n] for n in ("ROS_DISTRO", "CONDA_DEFAULT_ENV")), os.getcwd(), flush=True)
print("cpus", sorted(os.sched_getaffinity(0)), flush=True)
time.sleep(TOKEN)
"""


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """The home of a user of ros_base."""
    for folder in ("work/controller", "work/a/b", "ros_ws", "bin"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "ros_ws/setup.sh").write_text(
        "export ROS_DISTRO=jazzy\n[ $# = 0 ] || exit 9\nfalse\n"
    )
    (tmp_path / "bin/conda").write_text(CONDA)
    (tmp_path / "bin/conda").chmod(0o755)
    (tmp_path / "bin/python").symlink_to(sys.executable)
    return tmp_path


@pytest.fixture
def tmux(tmp_path: Path) -> Iterator[OwnTmux]:
    with own_tmux(tmp_path) as own:
        yield own


def surroundings(home: Path) -> dict[str, str]:
    path = f"{home / 'bin'}{os.pathsep}{os.environ['PATH']}"
    return {"HOME": str(home), "PATH": path, "CONDA_EXE": ""}


def last_cpu() -> int:
    return max(os.sched_getaffinity(0))


@pytest.mark.parametrize("script", ["", SCRIPT], ids=["rosbase up", "BaseLauncher"])
@pytest.mark.parametrize("text", [SESSIONS, AT_THE_ROOT], ids=["sessions", "root"])
def test_a_file_of_ros_base_runs_as_it_is(home: Path, text: str, script: str) -> None:
    text = text.replace("CPU", str(last_cpu()))
    with up(home, text, name="robot.yaml", script=script, environment=surroundings(home)) as (
        launcher,
        token,
    ):
        (home / "work/controller/run.py").write_text(RUN.replace("TOKEN", token.text))
        launcher.waits_for("VISION * ended with status 0")
        launcher.waits_for(f"LOW_LEVEL | cpus [{last_cpu()}]")
        assert launcher.end(signal.SIGINT) == 0
    said = launcher.said
    assert f"LOW_LEVEL | low jazzy robot {home}/work/controller" in said
    assert f"VISION | vision blue jazzy robot {home}/work/a/b" in said
    assert not [line for line in said if line.startswith("ALL |")]


@needs_tmux
@pytest.mark.parametrize("script", ["", SCRIPT], ids=["rosbase up", "BaseLauncher"])
@pytest.mark.parametrize("text", [SESSIONS, AT_THE_ROOT], ids=["sessions", "root"])
def test_a_file_of_ros_base_runs_in_panes(
    home: Path, tmux: OwnTmux, text: str, script: str
) -> None:
    text = text.replace("CPU", str(last_cpu()))
    environment = surroundings(home) | tmux.environment
    with up(home, text, "--tmux", name="robot.yaml", script=script, environment=environment) as (
        launcher,
        token,
    ):
        (home / "work/controller/run.py").write_text(RUN.replace("TOKEN", token.text))
        assert launcher.end() == 0
        assert launcher.said == ["demo_system: tmux attach -t demo_system"]
        tmux.waits_for("demo_system", {"LOW_LEVEL": "", "VISION": "0"})
        wait_until(lambda: f"cpus [{last_cpu()}]" in tmux.text("demo_system", 0), "its CPUs")
        assert tmux("list-windows", "-t", "demo_system", "-F", "#W").split() == ["MAIN"]
        assert f"low jazzy robot {home}/work/controller" in tmux.text("demo_system", 0)
        assert f"vision blue jazzy robot {home}/work/a/b" in tmux.text("demo_system", 1)
        tmux("kill-session", "-t", "demo_system")
        wait_until_gone(home)


def launchers(folder: Path) -> list[int]:
    """The launchers behind tmux that were started in a folder."""
    found = []
    for name in os.listdir("/proc"):
        if name.isdigit() and b"rosbase.launcher.tmux.background" in read_of(int(name), "cmdline"):
            try:
                if os.readlink(f"/proc/{name}/cwd") == str(folder):
                    found.append(int(name))
            except OSError:
                # It has just ended.
                continue
    return found


def wait_until_gone(folder: Path) -> None:
    wait_until(lambda: not launchers(folder), "the end of the launcher")


SLEEPERS = """
env: {session_name: demo}
nodes:
  - {name: a, command: "echo up; exec sleep TOKEN"}
  - {name: b, command: "exec sleep TOKEN", after: {a: "log: ^up$"}}
  - {name: crash, command: "echo last words; exit 3", after: b, restart: {limit: 1, backoff_s: 0}}
"""


@needs_tmux
def test_each_session_of_a_file_is_one_of_tmux_and_programs_wait_across(
    tmp_path: Path, tmux: OwnTmux, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    text = """
sessions:
  - env: {session_name: left}
    nodes: [{name: a, command: exec sleep TOKEN, after: {b: "log: up"}}]
  - env: {session_name: right.arm}
    nodes:
      - {name: b, command: "sleep 0.2; echo up; sleep TOKEN"}
      - {name: off, command: exec sleep TOKEN, autostart: false}
"""
    with up(tmp_path, text, "--tmux", name="robot.yaml", environment=tmux.environment) as (
        launcher,
        token,
    ):
        assert launcher.end() == 0
        assert launcher.said == ["left: tmux attach -t left", "right_arm: tmux attach -t right_arm"]
        token.wait_for_sleepers(2)
        assert tmux.panes("left") == {"a": ""}
        assert tmux.panes("right_arm") == {"b": ""}
        # A program that was disabled gets its pane when it is started.
        connect().restart("off")
        token.wait_for_sleepers(3)
        assert tmux.panes("right_arm") == {"b": "", "off": ""}
        connect().stop("a")
        tmux.waits_for("left", {"a": "130"})
        connect().restart("a")
        token.wait_for_sleepers(3)
        assert tmux.panes("left") == {"a": ""}
        connect().stop("/left")
        token.wait_until_gone()
        wait_until_gone(tmp_path)


@needs_tmux
def test_tmux_takes_no_name_and_no_folder_for_a_command(tmp_path: Path, tmux: OwnTmux) -> None:
    folder = tmp_path / "#(touch ${PWD}folder)100%;"
    folder.mkdir()
    names = ["A#(touch${IFS}pane)", "B#S", "C;", "##{pid}"]
    nodes = "".join(f"  - {{name: '{name}', command: pwd}}\n" for name in names)
    session = (
        'env: {session_name: "$1#(touch x)\\t#{pid};", workspace_root: \'' + folder.name + "'}\n"
    )
    text = (
        f"{session}nodes:\n{nodes}  - {{name: last, command: 'true', after: {{B#S: 'log: 100'}}}}\n"
    )
    # A short one, because a socket is in it.
    with (
        tempfile.TemporaryDirectory(prefix="#S%d") as temporary,
        up(
            tmp_path,
            text,
            "--tmux",
            name="robot.yaml",
            environment=tmux.environment | {"TMPDIR": temporary},
        ) as (launcher, _),
    ):
        assert launcher.end() == 0, launcher.said
        name = "_1__touch_x____pid__"
        assert launcher.said == [f"{name}: tmux attach -t {name}"]
        tmux.waits_for(name, dict.fromkeys([*names, "last"], "0"))
        assert str(folder) in tmux.text(name, 0).replace("\n", "")
        wait_until_gone(tmp_path)
    assert not list(folder.iterdir())
    names = [file.name for file in tmp_path.iterdir() if not file.name.startswith("tmux-")]
    assert sorted(names) == [folder.name, "robot.yaml"]


@needs_tmux
def test_panes_work_although_the_folder_for_temporary_files_is_deep(
    tmp_path: Path, tmux: OwnTmux
) -> None:
    deep = tmp_path / ("x" * 100)
    deep.mkdir()
    text = "env: {session_name: demo}\nnodes: [{name: a, command: 'true'}]\n"
    environment = tmux.environment | {"TMPDIR": str(deep)}
    with up(tmp_path, text, "--tmux", name="robot.yaml", environment=environment) as (
        launcher,
        _,
    ):
        assert launcher.end() == 0, launcher.said
        tmux.waits_for("demo", {"a": "0"})
        wait_until_gone(tmp_path)


@needs_tmux
def test_a_crash_leaves_its_pane_readable_and_the_others_alone(
    tmp_path: Path, tmux: OwnTmux
) -> None:
    with up(tmp_path, SLEEPERS, "--tmux", name="robot.yaml", environment=tmux.environment) as (
        launcher,
        token,
    ):
        assert launcher.end() == 0
        tmux.waits_for("demo", {"a": "", "b": "", "crash": "3"})
        text = tmux.text("demo", 2)
        assert text.count("last words") == 2
        assert "[rosbase] ended with status 3" in text
        assert "[rosbase] not started again: 1 in a row" in text
        assert len(token.sleepers()) == 2
        [background] = launchers(tmp_path)
        os.kill(background, signal.SIGTERM)
        token.wait_until_gone()
        # The panes stay, for whoever wants to read them.
        tmux.waits_for("demo", {"a": "130", "b": "130", "crash": "3"})
        wait_until_gone(tmp_path)


@needs_tmux
@pytest.mark.parametrize("number", [1, 4])
def test_the_last_words_in_a_pane_can_be_seen_when_a_smaller_terminal_attaches(
    tmp_path: Path, tmux: OwnTmux, number: int
) -> None:
    nodes = "".join(
        f"\n  - {{name: p{n}, command: echo last words {n}; exit 5}}" for n in range(number)
    )
    text = f"env: {{session_name: demo}}\nnodes:{nodes}"
    with up(tmp_path, text, "--tmux", name="robot.yaml", environment=tmux.environment) as (
        launcher,
        _,
    ):
        assert launcher.end() == 0
        tmux.waits_for("demo", {f"p{n}": "5" for n in range(number)})
        wait_until_gone(tmp_path)
        with on_terminal(
            *("tmux", "attach", "-t", "demo"), columns=80, environment=tmux.environment
        ) as terminal:
            wait_until(lambda: "80" in tmux("list-clients", "-F", "#{client_width}"), "a client")
            shown = [tmux("capture-pane", "-p", "-t", f"demo:MAIN.{n}") for n in range(number)]
            tmux("detach-client", "-s", "demo")
            terminal.process.wait(20)
    for n in range(number):
        assert f"last words {n}" in shown[n]
        assert "ended with status 5" in shown[n]


@needs_tmux
def test_a_session_has_the_size_of_the_terminal_unless_it_has_many_panes(
    tmp_path: Path, tmux: OwnTmux
) -> None:
    nodes = [f"{{name: p{n}, command: 'true'}}" for n in range(2)]
    (tmp_path / "few.yaml").write_text(f"nodes: [{', '.join(nodes)}]")
    command = (ROSBASE, "up", str(tmp_path / "few.yaml"), "--tmux")
    with on_terminal(*command, columns=90, environment=tmux.environment) as terminal:
        terminal.process.wait(20)
    assert tmux("list-windows", "-t", "few", "-F", "#{window_width}").strip() == "90"
    tmux.waits_for("few", {"p0": "0", "p1": "0"})
    assert session_size((80, 24), 16) == (80, 24)
    assert session_size((80, 24), 17) == session_size(None, 1) == (240, 120)


@needs_tmux
def test_ctrl_c_in_a_pane_stops_that_program_for_good(tmp_path: Path, tmux: OwnTmux) -> None:
    text = SLEEPERS.replace("{limit: 1, backoff_s: 0}", "always").replace("exit 3", "sleep TOKEN")
    with up(tmp_path, text, "--tmux", name="robot.yaml", environment=tmux.environment) as (
        launcher,
        token,
    ):
        assert launcher.end() == 0
        token.wait_for_sleepers(3)
        tmux("send-keys", "-t", "demo:MAIN.2", "C-c")
        tmux.waits_for("demo", {"a": "", "b": "", "crash": "130"})
        assert len(token.wait_for_sleepers(2)) == 2
        tmux("kill-pane", "-t", "demo:MAIN.0")
        token.wait_for_sleepers(1)
        tmux("kill-session", "-t", "demo")
        token.wait_until_gone()
        wait_until_gone(tmp_path)


@needs_tmux
@pytest.mark.parametrize("victim", ["launcher", "server", "guardian", "pane"])
def test_whoever_is_killed_no_process_is_left(tmp_path: Path, tmux: OwnTmux, victim: str) -> None:
    text = SLEEPERS.replace('"exec sleep TOKEN"', '"setsid sleep TOKEN & sleep TOKEN"')
    text = text.replace("{limit: 1, backoff_s: 0}", "never")
    with up(tmp_path, text, "--tmux", name="robot.yaml", environment=tmux.environment) as (
        launcher,
        token,
    ):
        assert launcher.end() == 0
        token.wait_for_sleepers(3)
        tmux.waits_for("demo", {"a": "", "b": "", "crash": "3"})
        [background] = launchers(tmp_path)
        if victim in ("launcher", "server"):
            os.kill(background if victim == "launcher" else tmux.server(), signal.SIGKILL)
        else:
            numbers = tmux("list-panes", "-s", "-t", "demo", "-F", "#{pane_pid}").split()
            panes = [int(number) for number in numbers[:2]]
            guardians = [pid for pid in token.bearers() if parent_of(pid) in panes]
            for pid in panes if victim == "pane" else guardians:
                os.kill(pid, signal.SIGKILL)
        token.wait_until_gone()
        wait_until_gone(tmp_path)


@needs_tmux
def test_a_session_of_that_name_is_replaced_after_its_programs_have_ended(
    tmp_path: Path, tmux: OwnTmux
) -> None:
    # Each refuses to run beside another one.
    alone = (
        "mkdir one || exit 9; trap 'sleep 0.3; rmdir one; exit' INT; echo up; sleep TOKEN & wait"
    )
    text = f'env: {{session_name: demo}}\nnodes: [{{name: a, command: "{alone}"}}]\n'
    tmux("new-session", "-d", "-s", "demo", "-n", "OTHER", "sleep 100")
    start = partial(up, tmp_path, text, "--tmux", name="robot.yaml", environment=tmux.environment)
    with start() as (first, _):
        assert first.end() == 0
        wait_until(lambda: "up" in tmux.text("demo", 0), "its start")
        [before] = launchers(tmp_path)
        with start() as (second, _):
            assert second.end() == 0
            wait_until(lambda: "up" in tmux.text("demo", 0), "its start")
            assert tmux("list-windows", "-t", "demo", "-F", "#W").split() == ["MAIN"]
            [background] = launchers(tmp_path)
            assert background != before
            os.kill(background, signal.SIGTERM)
            wait_until_gone(tmp_path)


def test_a_terminal_shows_the_states_below_the_output_and_names_in_colours(
    tmp_path: Path,
) -> None:
    text = """
nodes:
  - {name: setup, command: "echo ready; exec true"}
  - {name: camera_with_a_long_name, command: "echo hello; exec sleep 1000", after: {setup: exit 0}}
  - {name: later, command: "echo late", after: {camera_with_a_long_name: "log: never"}}
"""
    (tmp_path / "robot.yaml").write_text(text)
    command = (ROSBASE, "up", str(tmp_path / "robot.yaml"))
    with on_terminal(*command, columns=80) as plain:
        plain.waits_for("hello")
        plain.waits_for("1 running")
        plain.process.send_signal(signal.SIGINT)
        screens = plain.screens("3 programs: 2 stopped, 1 ended")
    assert not re.search(rb"\x1b\[[0-9;]*m", plain.shown)
    whole = [screen for screen in screens if any("1 running" in line for line in screen)][-1]
    lines = [line for line in whole if line]
    assert all(len(line) < 80 for line in lines)
    assert "camera_with_a_long_name | hello" in lines
    table = [" ".join(line.split()[:2]) for line in lines[-4:]]
    assert table[:3] == ["setup ended", "camera_with_a_long_name running", "later waiting"]
    assert lines[-1] == "3 programs: 1 waiting, 1 running, 1 ended; Ctrl-C stops all"
    with on_terminal(*command, columns=80, environment={"TERM": "xterm"}) as coloured:
        coloured.waits_for("1 running")
        coloured.end()
    assert b"\x1b[36msetup" in coloured.shown


def test_long_and_wide_names_leave_no_copies_of_the_table(tmp_path: Path) -> None:
    text = f"""
nodes:
  - {{name: {"n" * 60}, command: "echo hello; exec sleep 1000"}}
  - {{name: {"雪" * 20}, command: "echo also; exec sleep 1000"}}
  - {{name: late, command: "true", after: {{{"雪" * 20}: "log: {"雪" * 30}"}}}}
  - {{name: off, command: "true", autostart: false}}
"""
    (tmp_path / "robot.yaml").write_text(text)
    with on_terminal(*(ROSBASE, "up", str(tmp_path / "robot.yaml")), columns=80) as terminal:
        terminal.waits_for("also")
        terminal.waits_for("2 running")
        terminal.process.send_signal(signal.SIGINT)
        screens = terminal.screens("3 stopped, 1 disabled")
    last = [line for line in screens[-1] if line]
    assert [line.split()[1] for line in last[-5:-2]] == ["stopped"] * 3
    # No row of an earlier table is left.
    assert not [line for line in last if re.search(r"running +[0-9]", line)]
    assert [line.split() for line in last[-2:-1]] == [["off", "disabled"]]


@given(launcher_data)
def test_a_description_means_the_same_in_yaml_as_in_a_program(config: dict[str, object]) -> None:
    plain, written = Faults(), Faults()
    text = yaml.safe_dump(config, sort_keys=False, allow_unicode=True)
    here = Path("/here/robot.yaml")
    description = read_text(text, here, written)
    expected = read_mapping(config, here.parent, plain)
    assert len(written.in_order()) >= bool(plain.in_order())
    if not plain.in_order():
        assert _without_names(description) == _without_names(expected)


def _without_names(description: Description) -> list[object]:
    return [
        (one.name, one.commands, one.cpus, one.restart, one.is_required, one.folder)
        for one in description.programs
    ]


ONE = "nodes: [{name: a, command: b"
ALIASES = """
.common: &common {restart: always, project: a}
nodes:
  - {<<: *common, name: x, command: x}
  - {<<: *common, name: y, command: y, project: b}
"""


def test_aliases_and_merged_keys_work() -> None:
    faults = Faults("robot.yaml")
    description = read_text(ALIASES, Path("/here/robot.yaml"), faults)
    assert [str(fault) for fault in faults.in_order()] == [
        "robot.yaml:2: the file has no '.common'; it has env, nodes"
    ]
    assert [one.folder.name for one in description.programs] == ["a", "b"]
    assert {one.restart.when for one in description.programs} == {"always"}


def test_a_merged_mapping_that_is_merged_again_repeats_no_key() -> None:
    text = """
nodes:
  - &a
    name: A
    command: ls
    env: &e {X: "1", Y: "2"}
  - &b
    <<: *a
    name: B
    env: &f
      <<: *e
      X: "3"
  - <<: *b
    name: C
    env: *f
"""
    faults = Faults("robot.yaml")
    description = read_text(text, Path("/here/robot.yaml"), faults)
    assert not faults.in_order()
    assert [one.environment["X"] for one in description.programs] == ["1", "3", "3"]


def test_an_empty_variable_is_empty_however_it_is_written() -> None:
    faults = Faults("robot.yaml")
    text = "nodes: [{name: a, command: b, env: {X: ~, Y: null, Z: }}]"
    [program] = read_text(text, Path("/here/robot.yaml"), faults).programs
    assert program.environment == {"X": "", "Y": "", "Z": ""}


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (f"{ONE}, autostart: !!bool maybe}}]", "robot.yaml:1: autostart is true or false, not"),
        (f'{ONE}, after_timeout_s: !!int ""}}]', "robot.yaml:1: after_timeout_s is a number"),
        (f'{ONE}, after_timeout_s: !!float ""}}]', "robot.yaml:1: after_timeout_s is a number"),
        (f"{ONE},\n after: [\n a]}}]", "robot.yaml:3: 'a' waits for itself"),
        (f"{ONE},\n after: {{\n b: exit 0}}}}]", "robot.yaml:3: after: no program"),
        (f"{ONE},\n env: {{X: 1,\n 1: 1}}}}]", "robot.yaml:3: env: '1' is no environment"),
        ("nodes: [{name: a, command: [x,\n ' ']}]", "robot.yaml:2: command is a text"),
        ("nodes: [\n", "robot.yaml:2: not YAML: "),
        ("nodes: []\n---\nnodes: []\n", "robot.yaml:3: a second document begins here"),
        ("", "robot.yaml: the file is empty"),
        ("a: &a [*a]\n", "robot.yaml: nested too deeply, or too large"),
        ("nodes: []\nnodes: []\n", "robot.yaml:2: 'nodes' is already in line 1"),
        ("nodes:\n  - name: a\n    command: true\n    cpus: 9-\n", "robot.yaml:4: cpus is a list"),
        ("nodes:\n - [1]: 2\n", "robot.yaml:2: "),
        ("nodes:\n - \x00", "robot.yaml:2: not YAML: special characters are not allowed: #x0000"),
    ],
)
def test_a_mistake_of_yaml_is_named_with_its_line(text: str, fault: str) -> None:
    faults = Faults("robot.yaml")
    read_text(text, Path("/here/robot.yaml"), faults)
    assert any(str(one).startswith(fault) for one in faults.in_order()), faults.in_order()


def test_the_page_on_launching_runs_as_it_is_written(tmp_path: Path) -> None:
    page = ROOT / "docs/how-to/launch.md"
    write_files(page, tmp_path, "")
    shown = next(block for block in BLOCKS.values() if block.page == page and block.kind == "text")
    for name in ("robot", "order"):
        text = (tmp_path / f"{name}.yaml").read_text()
        with up(tmp_path, text, name=f"{name}.yaml") as (launcher, _):
            if name == "order":
                launcher.waits_for("UI * starting")
                assert launcher.end(signal.SIGINT) == 0
            else:
                assert launcher.end() == 0
                expected = [" ".join(line.split()) for line in shown.text.splitlines()]
                assert [line for line in launcher.said if "INFO" not in line] == expected


def test_the_page_on_launching_names_every_key_and_every_condition() -> None:
    page = (ROOT / "docs/how-to/launch.md").read_text()
    rows = {line.split("`")[1] for line in page.splitlines() if line.startswith("| `")}
    keys = {*PROGRAM_KEYS, *RESTART_KEYS, *ENV_KEYS}
    conditions = {"log: PATTERN", *get_args(ConditionKind)} - {"log"}
    assert rows == keys | conditions


def test_a_conda_environment_that_does_not_exist_is_a_mistake(home: Path) -> None:
    text = "env: {workspace_root: ~/work,\n conda_env: rabbit}\nnodes: [{name: a, command: x}]\n"
    with up(home, text, "--check", name="robot.yaml", environment=surroundings(home)) as (
        launcher,
        _,
    ):
        assert launcher.end() == 2
    fault = "robot.yaml:2: conda_env: cannot activate 'rabbit': no environment rabbit"
    assert launcher.said == [fault]
