"""What editors and interactive sessions show of rosbase: its names, its version, and reprs."""

import subprocess
import sys
from importlib.metadata import version
from typing import Any

import pytest

import rosbase
from rosbase import (
    BaseManager,
    BaseNode,
    LifecycleNode,
    Parameter,
    State,
)
from rosbase.fsm import Machine, Transition
from rosbase.runtime.histogram import Histogram
from rosbase.runtime.rate import LoopStats
from rosbase.testing import virtual_backend
from support.roles import Camera, StopAfter


def python(program: str) -> str:
    """What a program prints in a Python of its own."""
    command = [sys.executable, "-W", "error", "-c", program]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def test_the_version_is_the_one_that_is_installed() -> None:
    assert rosbase.__version__ == version("rosbase-core")


def test_importing_rosbase_imports_neither_its_modules_nor_the_metadata() -> None:
    program = "import sys, rosbase; dir(rosbase); print(sorted(sys.modules))"
    loaded = python(program)
    assert "importlib.metadata" not in loaded
    assert "rosbase." not in loaded


def test_dir_lists_every_public_name_before_any_is_used_and_no_internal_one() -> None:
    names = python("import rosbase; print(*dir(rosbase))").split()
    assert {"__version__", *rosbase.__all__} <= set(names)
    public = [name for name in names if not name.startswith("__")]
    assert public == sorted(rosbase.__all__)


def test_dir_lists_a_public_module_once_it_is_imported_and_never_an_internal_one() -> None:
    names = python("import rosbase.fsm; from rosbase import BaseManager; print(*dir(rosbase))")
    assert "fsm" in names.split()
    assert not {"manager", "roles", "import_module", "_HOMES"} & set(names.split())


def test_a_manager_shows_its_name_its_parts_and_where_it_is() -> None:
    manager = BaseManager(
        "robot",
        {"camera": Camera},
        handlers_class=StopAfter,
        start_state="idle",
        backend=virtual_backend(),
    )
    assert repr(manager.nodes["camera"]) == "<Camera 'camera'>"
    assert repr(manager.handlers) == "<StopAfter>"
    manager.start_main_loop_timer()
    assert f"nodes=['camera'] agents=[] state='idle' timestamp={manager.timestamp}>" in repr(
        manager
    )


def test_a_manager_without_a_backend_yet_can_be_shown() -> None:
    assert repr(BaseManager.__new__(BaseManager)) == "<BaseManager under construction>"


def test_a_lone_node_shows_its_own_name() -> None:
    node = BaseNode(node_name="lone", backend="local")
    node.destroy_node()
    assert repr(node) == "<BaseNode 'lone'>"


def test_a_lifecycle_node_shows_its_state() -> None:
    node = LifecycleNode(node_name="lone", backend="local")
    assert repr(node) == "<LifecycleNode 'lone' unconfigured>"
    node.trigger_configure()
    assert repr(node) == "<LifecycleNode 'lone' inactive>"
    node.destroy_node()


@pytest.mark.parametrize("node_class", [BaseNode, LifecycleNode])
def test_a_node_whose_constructor_has_not_run_can_be_shown(node_class: Any) -> None:
    assert repr(node_class.__new__(node_class)) == f"<{node_class.__name__}>"


def test_the_times_of_the_loop_are_shown_in_milliseconds() -> None:
    stats = LoopStats()
    stats.notes += [0, 1_000_000, 5_000_000, 6_000_000]
    stats.overruns = 2
    assert repr(stats) == "<LoopStats ticks=2 overruns=2 period_p50_ms=5.000 busy_p50_ms=1.000>"


def test_a_histogram_shows_its_percentiles() -> None:
    histogram = Histogram()
    assert repr(histogram) == "<Histogram count=0 p50=0 p99=0 maximum=0>"
    histogram.record_all(range(1, 21))
    assert repr(histogram) == "<Histogram count=20 p50=10 p99=20 maximum=20>"


def test_a_machine_shows_where_it_is_and_where_it_was() -> None:
    machine = Machine("search", [Transition("search", "grasp", when=lambda: True)])
    machine.step()
    shown = "state='grasp' previous='search' steps_in_state=0 states=['search', 'grasp']"
    assert repr(machine) == f"<Machine {shown}>"


def test_a_parameter_shows_its_name_and_value() -> None:
    assert repr(Parameter("rate", 50)) == "Parameter(name='rate', value=50)"


@pytest.mark.parametrize("state", list(State))
def test_a_state_prints_its_label_and_still_counts_as_its_id(state: State) -> None:
    assert (str(state), f"{state}", "%s" % state) == (state.label,) * 3  # noqa: UP031 - the old way of formatting, too
    assert (state, f"{state:d}", int(state)) == (state.id, str(state.id), state.id)
    assert repr(state) == f"<State.{state.name}: {state.id}>"
