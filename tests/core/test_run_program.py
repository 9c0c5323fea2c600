"""`rosbase run`: any program, with parameters, backend and log levels from outside."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from support.log_lines import without_times

APP = """\
    import sys
    from typing import Any
    from rosbase import BaseHandlers, BaseManager, BaseNode

    class Camera(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.fps = self.declare_parameter("fps", 30).value
            self.logger.debug("built")

    class Stopping(BaseHandlers):
        def handle(self) -> None:
            cameras = {name: node.fps for name, node in self.nodes.items()}
            print(cameras, sys.argv[1:], __name__)
            self.manager.request_stop()

    class Robot(BaseManager):
        def __init__(self, **kwargs: Any) -> None:
            cameras = {"front": Camera, "rear": Camera}
            super().__init__("robot", cameras, handlers_class=Stopping, **kwargs)

    def main() -> None:
        Robot(log_freq=False).start_main_loop_timer()

    number = 5

    if __name__ == "__main__":
        main()
"""


@pytest.fixture
def app(tmp_path: Path) -> Path:
    import textwrap

    (tmp_path / "app.py").write_text(textwrap.dedent(APP))
    return tmp_path


def run(folder: Path, *words: str) -> "subprocess.CompletedProcess[str]":
    done = subprocess.run(
        [sys.executable, "-m", "rosbase", "run", *words],
        cwd=folder, capture_output=True, text=True, check=False, timeout=40,
        env={**os.environ, "ROSBASE_BACKEND": "local"},
    )  # fmt: skip
    done.stderr = without_times(done.stderr)
    return done


@pytest.mark.parametrize(
    ("target", "module"),
    [("app.py", "__main__"), ("app", "__main__"), ("app:Robot", "app"), ("app:main", "app")],
)
def test_a_file_a_module_a_class_or_a_function(app: Path, target: str, module: str) -> None:
    done = run(app, target, "-p", "front.fps:=25", "own", "--flag")
    assert done.stdout == f"{{'front': 25, 'rear': 30}} ['own', '--flag'] {module}\n", done.stderr
    assert (done.returncode, done.stderr) == (0, "")


def test_options_may_stand_before_and_after_the_program(app: Path) -> None:
    (app / "robot.toml").write_text("fps = 1\n[rear]\nfps = 2\n")
    done = run(app, "--params-file", "robot.toml", "-p", "rear.fps:=3", "app.py", "-p", "fps:=4")
    assert done.stdout.startswith("{'front': 4, 'rear': 3} []"), done.stderr
    done = run(app, "app.py", "--", "-p", "fps:=5")
    assert done.stdout.startswith("{'front': 30, 'rear': 30} ['-p', 'fps:=5']"), done.stderr
    done = run(app, "app.py", "-port", "80", "-pfps:=4")
    assert done.stdout.startswith("{'front': 4, 'rear': 4} ['-port', '80']"), done.stderr
    done = run(app, "app.py", "-p", "fps:=4", "--", "-p", "fps:=5")
    assert done.stdout.startswith("{'front': 4, 'rear': 4} ['-p', 'fps:=5']"), done.stderr


def test_levels_are_of_all_loggers_or_of_one(app: Path) -> None:
    done = run(app, "app.py", "--log-level", "robot.rear:=debug")
    assert done.stderr == "[DEBUG] [robot.rear]: built\n"
    done = run(app, "app.py", "--log-level", "debug", "--log-level", "robot.front:=warn")
    assert done.stderr == "[DEBUG] [robot.rear]: built\n"


def test_the_log_goes_to_a_file_too(app: Path) -> None:
    done = run(app, "app.py", "--log-file", "logs/robot.log", "--log-level", "debug")
    assert "[DEBUG] [robot.rear]: built\n" in done.stderr
    assert without_times((app / "logs" / "robot.log").read_text()) == done.stderr


@pytest.fixture
def walker(tmp_path: Path) -> Path:
    (tmp_path / "walker.py").write_text(
        "from rosbase import BaseNode, BaseHandlers, BaseManager, register_multiprocess_nodes\n"
        "class Walker(BaseNode):\n"
        "    def __init__(self, manager=None, **kwargs):\n"
        "        super().__init__(manager, **kwargs)\n"
        "        self.logger.debug('lame')\n"
        "        print('pace', self.declare_parameter('pace', 1.0).value, flush=True)\n"
        "        self.create_timer(0.05, self.request_stop)\n"
        "class Waiting(BaseHandlers):\n"
        "    def handle(self):\n"
        "        if self.manager.processes['left'].exit_code is not None:\n"
        "            self.manager.request_stop()\n"
        "def main():\n"
        "    children = register_multiprocess_nodes({'left': Walker})\n"
        "    manager = BaseManager('robot', handlers_class=Waiting)\n"
        "    manager.processes = children\n"
        "    manager.start_main_loop_timer(children)\n"
        "if __name__ == '__main__':\n"
        "    main()\n"
    )
    return tmp_path


def test_a_node_alone_and_a_child_process_are_given_theirs(walker: Path) -> None:
    done = run(walker, "walker:Walker", "-p", "pace:=2", "-p", "peace:=3")
    assert done.stdout == "pace 2.0\n", done.stderr
    said = "no node declares the parameter peace; did you mean pace?"
    assert done.stderr == f"[WARN] [Walker]: {said}\n"
    for given in ("left.pace:=4", "pace:=4"):
        done = run(walker, "walker.py", "-p", given)
        assert "left: pace 4.0" in done.stderr, done.stderr
        assert "no node declares" not in done.stderr


@pytest.mark.parametrize(
    ("levels", "said"),
    [
        ([], False),
        (["left:=debug"], True),
        (["warn", "left:=debug"], True),
        (["robot:=debug"], False),
        (["debug"], True),
        (["debug", "left:=info"], False),
    ],
    ids=lambda value: " ".join(value) or "none" if isinstance(value, list) else str(value),
)
def test_the_level_of_a_child_process_is_that_of_its_node(
    walker: Path, levels: list[str], said: bool
) -> None:
    options = [word for level in levels for word in ("--log-level", level)]
    done = run(walker, "walker.py", *options)
    assert ("left: lame" in done.stderr) is said, done.stderr


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["nope.py"], "rosbase run: nope.py: no such file"),
        (["nope"], "rosbase run: there is no file or module 'nope'"),
        (["./nope"], "rosbase run: ./nope: no such file"),
        ([".app"], "rosbase run: there is no file or module '.app'"),
        (["no.pe:X"], "rosbase run: there is no file or module 'no.pe'"),
        (["app:Nope"], "rosbase run: app has no Nope"),
        (["app:number"], "rosbase run: app:number is neither a manager nor a node nor a function"),
        (["app.py", "-p", "fps"], "rosbase: -p takes name:=value, not 'fps'"),
        (["app.py", "-p", "front.fps:=x"],
         "rosbase run: parameter front.fps takes a whole number, not 'x'"),
        (["app.py", "--params-file", "x.toml"], "rosbase: x.toml: No such file or directory"),
        (["app.py", "--backend", "warp"], "rosbase run: no backend 'warp'; installed: local"),
        (["app.py", "--log-level", "loud"],
         "rosbase: no log level is called 'loud': debug, info, warn, error, fatal"),
        ([], "rosbase run: the following arguments are required: PROGRAM, ..."),
    ],
)  # fmt: skip
def test_a_usage_error_is_one_line_and_status_2(app: Path, words: list[str], line: str) -> None:
    done = run(app, *words)
    assert (done.returncode, done.stderr, done.stdout) == (2, f"{line}\n", "")


def test_an_error_of_the_program_keeps_its_traceback_and_its_status(tmp_path: Path) -> None:
    (tmp_path / "app.py").write_text("import sys\nif sys.argv[1:]: sys.exit(7)\n1 / 0\n")
    done = run(tmp_path, "app.py")
    assert (done.returncode, done.stderr.splitlines()[-1]) == (
        1, "ZeroDivisionError: division by zero",
    )  # fmt: skip
    assert run(tmp_path, "app.py", "x").returncode == 7


def test_a_package_that_cannot_be_imported_says_why(tmp_path: Path) -> None:
    (tmp_path / "robot").mkdir()
    (tmp_path / "robot" / "__init__.py").write_text("import no_such_package\n")
    (tmp_path / "robot" / "app.py").write_text("")
    done = run(tmp_path, "robot.app")
    assert done.stderr.endswith("ModuleNotFoundError: No module named 'no_such_package'\n")


def test_a_function_ends_with_the_status_that_it_returns(tmp_path: Path) -> None:
    (tmp_path / "tool.py").write_text("def main():\n    return 3\n")
    assert run(tmp_path, "tool:main").returncode == 3


def test_what_a_program_takes_follows_what_it_was_given(app: Path) -> None:
    (app / "own.py").write_text(
        "from rosbase import take_arguments\n"
        "from app import Robot\n"
        "take_arguments(['-p', 'rear.fps:=2'])\n"
        "Robot().start_main_loop_timer()\n"
    )
    done = run(app, "own.py", "-p", "front.fps:=1", "-p", "rear.fps:=1")
    assert done.stdout.startswith("{'front': 1, 'rear': 2}"), done.stderr


def test_parameters_that_no_environment_can_hold_are_one_line(app: Path) -> None:
    (app / "long.toml").write_text(f"x = {list(range(30_000))}\n")
    done = run(app, "app.py", "--params-file", "long.toml")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("rosbase: the parameters are too long: ")


def test_parameters_that_are_declared_later_are_not_named(tmp_path: Path) -> None:
    (tmp_path / "arm.py").write_text(
        "from rosbase import BaseHandlers, BaseManager, CallbackReturn, LifecycleNode\n"
        "class Arm(LifecycleNode):\n"
        "    autostart = 'configure'\n"
        "    def on_configure(self, previous_state):\n"
        "        print(self.declare_parameter('speed', 1.0).value)\n"
        "        return CallbackReturn.SUCCESS\n"
        "class Stop(BaseHandlers):\n"
        "    def handle(self):\n"
        "        self.manager.request_stop()\n"
        "if __name__ == '__main__':\n"
        "    BaseManager('robot', {'arm': Arm}, {}, Stop).start_main_loop_timer()\n"
    )
    done = run(tmp_path, "arm.py", "-p", "arm.speed:=2", "-p", "arm.sped:=3")
    assert done.stdout == "2.0\n", done.stderr
    said = "no node declares the parameter arm.sped; did you mean arm.speed?"
    assert done.stderr == f"[WARN] [robot]: {said}\n"


def test_a_program_takes_the_same_arguments_with_one_call(app: Path) -> None:
    (app / "own.py").write_text(
        "import argparse\n"
        "from rosbase import take_arguments\n"
        "from app import Robot\n"
        "parser = argparse.ArgumentParser()\n"
        "parser.add_argument('--name')\n"
        "print(parser.parse_args(take_arguments()).name)\n"
        "Robot().start_main_loop_timer()\n"
    )
    done = subprocess.run(
        [sys.executable, "own.py", "-p", "front.fps:=25", "--name", "ann"],
        cwd=app, capture_output=True, text=True, check=False, timeout=40,
    )  # fmt: skip
    assert done.stdout.splitlines()[0] == "ann", done.stderr
    assert done.stdout.splitlines()[1].startswith("{'front': 25, 'rear': 30}")


def test_a_mistake_of_the_program_is_a_traceback_and_not_a_usage_error(app: Path) -> None:
    source = (app / "app.py").read_text()
    wrong = "            self.nodes['front'].get_parameter('fsp')\n"
    marker = "        def handle(self) -> None:\n".replace("        def", "    def", 1)
    (app / "app.py").write_text(source.replace(marker, marker + wrong[4:]))
    done = run(app, "app.py")
    assert done.returncode == 1
    assert "Traceback" in done.stderr
    assert "get_parameter('fsp')" in done.stderr


def test_a_directory_with_a_main_module_is_run(app: Path) -> None:
    folder = app / "robot"
    folder.mkdir()
    (folder / "__main__.py").write_text("import bridge, sys\nprint(bridge.NUMBER, sys.argv[1:])\n")
    (folder / "bridge.py").write_text("NUMBER = 5\n")
    for words in (["./robot"], ["robot"], [str(folder)]):
        assert run(app, *words, "x").stdout == "5 ['x']\n"


LATE = """
from rosbase import BaseHandlers, BaseManager, LifecycleNode, CallbackReturn

class Arm(LifecycleNode):
    def on_configure(self, state):
        if not self.has_parameter("speed"):
            self.declare_parameter("speed", 1.0)
        return CallbackReturn.SUCCESS

class Handlers(BaseHandlers):
    def handle(self):
        arm = self.node(Arm)
        if self.timestamp == 2:
            arm.trigger_configure()
            arm.trigger_cleanup()
            arm.trigger_configure()
        if self.timestamp == 150:
            self.manager.request_stop()

manager = BaseManager("robot", {"arm": Arm}, handlers_class=Handlers, node_freq_hz=100)
manager.start_main_loop_timer()
"""


def test_a_misspelt_parameter_is_named_when_the_node_that_may_declare_it_is_configured(
    tmp_path: Path,
) -> None:
    (tmp_path / "late.py").write_text(LATE)
    done = run(tmp_path, "late.py", "-p", "arm.sped:=2.0", "-p", "arm.speed:=3.0")
    assert done.stderr.count("\n") == 1, done.stderr
    assert "no node declares the parameter arm.sped; did you mean arm.speed?" in done.stderr


CHILD = """
from rosbase import BaseHandlers, BaseManager, BaseNode, register_multiprocess_nodes

class Walker(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.speed = self.declare_parameter("speed", 1.0).value
        self.create_timer(0.05, self.say)

    def say(self):
        self.logger.info(f"walks at {self.speed}")
        self.request_stop()

if __name__ == "__main__":
    children = register_multiprocess_nodes({"walker": Walker}, {}, required=True)
    BaseManager("robot", handlers_class=BaseHandlers).start_main_loop_timer(children)
"""


def test_a_child_names_the_misspelt_parameters_that_are_for_it(tmp_path: Path) -> None:
    (tmp_path / "walkers.py").write_text(CHILD)
    done = run(tmp_path, "walkers.py", "-p", "walker.sped:=2.0", "-p", "walker.speed:=3.0")
    assert "walks at 3.0" in done.stderr
    assert "no node declares the parameter walker.sped" in done.stderr
