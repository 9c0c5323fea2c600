"""The manager: owns everything in one process, and connects the roles."""

import sys
import threading
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Literal, TypeVar

from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.contracts.recording import Recording, RecordOptions
from rosbase.control.programs import may_be_offered, offered
from rosbase.lifecycle import State
from rosbase.logger import RosbaseLogger
from rosbase.manager.bringup import bring_up, take_down
from rosbase.manager.building import Builder
from rosbase.manager.clock_watch import ClockWatch
from rosbase.manager.frequency_log import FrequencyLog
from rosbase.manager.handshake import Handshake
from rosbase.manager.loops import TIMINGS, loop_of
from rosbase.manager.program import ManagerProgram
from rosbase.manager.state_switch import StateSwitch
from rosbase.manager.unrun import UnrunWork
from rosbase.parameters.given import are_inherited, given_parameters
from rosbase.processes import (
    ChildProcesses,
    register_multiprocess_nodes,
    shutdown_multiprocess_nodes,
    shutdown_unclaimed,
)
from rosbase.roles.agent import BaseAgent
from rosbase.roles.callables import check_answer, check_methods
from rosbase.roles.construction import Constructed, constructor
from rosbase.roles.handlers import BaseHandlers
from rosbase.roles.keywords import warn_of_untaken
from rosbase.roles.lifecycle_node import LifecycleNode
from rosbase.roles.lookup import find_component
from rosbase.roles.node import BaseNode
from rosbase.roles.recording import (
    end_recording,
    follow_stops,
    has_no_signals,
    note_interruption,
    open_program,
    recorded,
    run_aside,
)
from rosbase.roles.registration import Registration
from rosbase.roles.set_by_constructor import SetByConstructor, must_call_base
from rosbase.roles.shutdown import is_wish, name_threads_left, run_steps
from rosbase.runtime.rate import LoopStats, Rate
from rosbase.runtime.stopping import StopSignals, limit_real_time, stop_on_signals

# Programs written for ros_base import the two functions from here.
__all__ = ["BaseManager", "register_multiprocess_nodes", "shutdown_multiprocess_nodes"]

NodeT = TypeVar("NodeT", bound=BaseNode)
AgentT = TypeVar("AgentT", bound=BaseAgent)

# In virtual time a minute takes no time, and a test should not wait for ever.
_VIRTUAL_HANDSHAKE_S = 60.0
_ARGUMENTS = "*args, **kwargs"
# Neither async nor generators.
_PLAIN_METHODS = (
    "init_custom_variables",
    "handshake",
    "main_loop",
    "get_state_switch",
    "state_handle",
    "update_timestamp",
    "release_resources",
    "destroy_node",
)


class BaseManager(Constructed):
    """Registers nodes, agents and handlers, shakes hands, runs the main loop, cleans up.

    `start_main_loop_timer()` does all of this and returns when the application has ended.
    """

    backend: Backend
    """Connection of this process. On ROS 2, `backend.node` is the rclpy node."""
    logger: RosbaseLogger
    """Logger of the manager, agents and handlers. Its nodes have loggers of their own."""
    nodes: dict[str, Any]
    """Nodes by name, in the order of `nodes_dict`."""
    agents: dict[str, Any]
    """Agents by name, in the order of `agents_dict`."""
    handlers: BaseHandlers | None
    """Handlers; None without a `handlers_class`."""
    node_freq_hz: float
    """Ticks per second."""
    state: str | None
    """State of the application, to read and to set. rosbase itself gives it no meaning."""
    timestamp: int
    """Number of ticks that have ended."""
    loop_stats: LoopStats
    """Statistics of the main loop: ticks, skipped ticks, periods and durations."""
    get_state_switch: Callable[[], str | None] | None = None
    """Optional method, called at the start of each tick.

    If it returns something other than None, that becomes `state`. Like `state_handle`, it must
    exist when the main loop starts.
    """
    state_handle: Callable[..., object] | None = None
    """Optional method, called after `get_state_switch` and with its result if it takes an argument.
    """

    _recording: Recording | None = None
    _is_initialised = False
    """Whether the constructor of this class has come to the components."""

    @constructor
    def __init__(
        self,
        node_name: str = "BaseManager",
        nodes_dict: Mapping[str, type[BaseNode]] | None = None,
        agents_dict: Mapping[str, type[BaseAgent]] | None = None,
        handlers_class: type[BaseHandlers] | None = None,
        node_freq_hz: float = 200,
        start_state: str | None = None,
        custom_logger: Callable[[str], Any] | None = None,
        log_freq: bool = False,
        *args: Any,
        backend: str | Backend | None = None,
        handshake_timeout: float | None = None,
        timing: Literal["normal", "precise"] = "normal",
        control: bool = True,
        record: str | Path | RecordOptions | None = None,
        main_loop_timer: object = None,
        **kwargs: Any,
    ) -> None:
        """Build all components, in this order: nodes, agents, handlers.

        Args:
            node_name: Name of this process, as other programs see it.
            nodes_dict: Node classes by the name they get in `nodes`.
            agents_dict: Agent classes by the name they get in `agents`.
            handlers_class: The class whose `handle()` is called once per tick.
            node_freq_hz: Ticks per second.
            start_state: The first value of `state`.
            custom_logger: A class that is called with the node name for the logger.
            log_freq: Whether the measured rate is logged, once a second.
            args: Forwarded to every component as they are.
            backend: By name or ready made; by default what `ROSBASE_BACKEND` says, else `local`.
            handshake_timeout: Seconds after which a handshake that does not succeed is an error;
                by default never, and a minute in virtual time.
            timing: With `precise`, the loop spins for the last 100 us or so before each tick, which
                costs processor time. In virtual time, both are exact.
            control: Whether programs of this user, such as `rosbase topic list`, can look at this
                one and operate it while it runs. `ROSBASE_CONTROL=off` turns it off for all.
            record: File to which this program is recorded, or options with such a file; by default
                what `rosbase run --record` says. It needs rosbase-mcap.
            main_loop_timer: Accepted from older programs, and ignored.
            kwargs: Forwarded to every component as they are.

        Raises:
            TypeError: An instance is given instead of a class, or a method that rosbase calls
                is async or a generator.
            ValueError: The rate or the timeout is not a positive number, or there is no such
                timing.
            NotInstalledError: No backend of that name can be used, or no recorder.
            RecordingError: The recording cannot be created.
        """
        check_methods(self, _PLAIN_METHODS)
        self._known_threads = threading.enumerate()
        self.nodes = {}
        self.agents = {}
        options = BackendOptions(node_name=node_name)
        opened = open_program(record, backend, options, custom_logger)
        self.backend, self.logger, self._recording = opened
        follow_stops(self.backend, self._stop_now)
        self._registration = Registration(node_name, custom_logger is not None)
        self._prepare(node_freq_hz, start_state, log_freq, handshake_timeout, timing)
        self._program = ManagerProgram(self)
        self._is_offered = may_be_offered(self.backend, wanted=control)
        self._register(nodes_dict, agents_dict, handlers_class, args, kwargs)

    def _missing_base(self) -> str:
        return "" if self._is_initialised else must_call_base(self, _ARGUMENTS)

    def __repr__(self) -> str:
        if not hasattr(self, "loop_stats"):
            return f"<{type(self).__name__} under construction>"
        return (
            f"<{type(self).__name__} {self.backend.node_name!r}"
            f" nodes={list(self.nodes)} agents={list(self.agents)}"
            f" state={self.state!r} timestamp={self.timestamp}>"
        )

    def _end_program(self) -> None:
        if hasattr(self, "backend"):
            self.backend.end_run()

    def _abandon(self) -> None:
        """Give back what a constructor that failed has taken."""
        if hasattr(self, "logger"):
            nodes = reversed(self.nodes.items())
            run_steps(
                [(f"release_resources of {name}", node.release_resources) for name, node in nodes],
                self.logger,
            )
        if hasattr(self, "backend"):
            self.backend.close()
            end_recording(self._recording, self.backend, sys.exc_info()[1])
        # Children were started for this manager, and nobody else knows of them.
        shutdown_unclaimed()

    def _prepare(
        self,
        node_freq_hz: float,
        start_state: str | None,
        log_freq: bool,
        handshake_timeout: float | None,
        timing: str,
    ) -> None:
        """Set the attributes that components use while they are built."""
        Rate(node_freq_hz, 0)
        if handshake_timeout is not None and not _is_duration(handshake_timeout):
            raise ValueError(f"handshake_timeout is a number of seconds, not {handshake_timeout!r}")
        if timing not in TIMINGS:
            raise ValueError(f"timing is 'normal' or 'precise', not {timing!r}")
        self.node_freq_hz = node_freq_hz
        self.state = start_state
        self.timestamp = 0
        self.handlers = None
        self.loop_stats = LoopStats()
        self._handshake = Handshake(self.logger)
        self._handshake_timeout_s = handshake_timeout
        self._log_freq = log_freq
        self._frequency_log: FrequencyLog | None = None
        # A virtual clock stands still while somebody spins, and needs no spinning.
        self._run_loop = loop_of(self.backend, timing)
        self._processes: ChildProcesses | None = None
        self._stop_requests: list[bool] = []
        # Asked twice in each tick, so it is not a function in Python.
        self._is_stopping = self._stop_requests.__len__
        self._has_started = False
        # Whether there is anything in `get_state_switch` or `state_handle`; known at the start.
        self._may_switch = True
        # Whether `update_timestamp` is the one below; known at the start.
        self._counts_plainly = False
        self._unrun = UnrunWork(self.logger)
        self._state_switch = StateSwitch(self, self._unrun)
        # Whether a node may still declare parameters when it is configured.
        self._undeclared_later = False
        self._is_initialised = True
        self.init_custom_variables()

    def _register(
        self,
        nodes_dict: Mapping[str, type[BaseNode]] | None,
        agents_dict: Mapping[str, type[BaseAgent]] | None,
        handlers_class: type[BaseHandlers] | None,
        args: tuple[Any, ...],
        kwargs: dict[str, Any],
    ) -> None:
        components = [*(nodes_dict or {}).values(), *(agents_dict or {}).values(), handlers_class]
        warn_of_untaken(kwargs, [type(self), *components], BaseManager, self.logger.warning)

        builder = Builder(self, self._registration, self.logger, args, kwargs)
        for name, node_class in (nodes_dict or {}).items():
            where = f"nodes_dict[{name!r}]"
            self.nodes[name] = builder.build(node_class, where, name, ("release_resources",))
        for name, agent_class in (agents_dict or {}).items():
            where = f"agents_dict[{name!r}]"
            self.agents[name] = builder.build(agent_class, where, name, ("reset",))
        if handlers_class is not None:
            self.handlers = builder.build(handlers_class, "handlers_class", "", ("handle",))

    # What users override.

    def init_custom_variables(self) -> None:
        """Prepare attributes that components expect. Called before the first component is built."""

    def handshake(self) -> bool | None:
        """Return False to keep waiting. Called repeatedly, with messages handled in between."""
        return self._handshake.ask()

    def main_loop(self) -> None:
        """Run one tick. Override it to change the order of the calls."""
        if self._may_switch:
            self._state_switch.step()
        handlers = self.handlers
        if handlers is not None:
            answer = handlers.handle()  # type: ignore[func-returns-value]  # as declared
            if answer is not None:
                self._unrun.report(handlers, "handle", answer)
        if self._counts_plainly:
            self.timestamp += 1
        else:
            self.update_timestamp()

    def update_timestamp(self) -> None:
        """Increment `timestamp`. Called at the end of each tick."""
        self.timestamp += 1

    def release_resources(self) -> None:
        """Release windows, files, threads and devices. Called when the application ends."""

    # What users call.

    def add_handshake_rule(self, name: str, predicate: Callable[[], object]) -> None:
        """Add a condition that must hold before the main loop starts."""
        self._handshake.add(name, predicate)

    def node(self, node_class: type[NodeT], name: str | None = None) -> NodeT:
        """Return the node of that class, typed as such: the only one, or the one of that name.

        Args:
            node_class: Its class, or a base of it.
            name: Its name in `nodes`, needed only if several nodes are of the class.

        Raises:
            LookupError: There is none, or several and no name.
        """
        return find_component(self.nodes, node_class, name, "node")

    def agent(self, agent_class: type[AgentT], name: str | None = None) -> AgentT:
        """Return the agent of that class, as `node` does for nodes.

        Raises:
            LookupError: There is none, or several and no name.
        """
        return find_component(self.agents, agent_class, name, "agent")

    @property
    def recording(self) -> Recording | None:
        """Recording of this program; None if it is not recorded.

        `recording.save()` writes what `RecordOptions.last_s` keeps in memory.
        """
        return self._recording

    def request_stop(self) -> None:
        """End the main loop after the current tick. Call it from any thread or signal handler."""
        if self._processes is not None:
            self._processes.stopping_soon()
        self.backend.executor.stop_soon(self._stop_now)

    def start_main_loop_timer(self, processes: ChildProcesses | None = None) -> None:
        """Run the handshake, bring lifecycle nodes up, run the main loop, and clean up.

        Returns when stopped, by `request_stop`, SIGINT, SIGTERM or SIGHUP. An exception of
        user code is raised here, after the whole clean-up. A manager runs once.

        Args:
            processes: Result of `register_multiprocess_nodes`; stopped at the end.

        Raises:
            HandshakeTimeoutError: The rules that it names did not come true in time.
            RuntimeError: It has run already, or is running.
            SystemExit: A required child has ended with this status, which is not 0.
            TypeError: `processes` is something else, or a method that rosbase calls is async or
                a generator, or returns a coroutine as its answer.
        """
        if self._has_started:
            raise RuntimeError("a manager runs once; make a new one")
        self._has_started = True
        self._may_switch = self._state_switch.is_used
        self._counts_plainly = (
            getattr(self.update_timestamp, "__func__", None) is BaseManager.update_timestamp
        )
        executor = self.backend.executor
        if has_no_signals(self.backend):
            # The signals of a test are its runner's.
            with limit_real_time(executor.clock, executor.call_urgently):
                self._run(processes, None)
            return
        request_stop = partial(executor.in_signal, self.request_stop)
        with (
            stop_on_signals(request_stop, executor.call_urgently) as stop,
            offered(self._program if self._is_offered else None, self.logger),
        ):
            self._run(processes, stop)

    def _run(self, processes: ChildProcesses | None, stop: StopSignals | None) -> None:
        with recorded(self._recording, self.backend):
            self._run_through(processes, stop)

    def _run_through(self, processes: ChildProcesses | None, stop: StopSignals | None) -> None:
        try:
            self.backend.executor.begin(self._is_stopping)
            self.backend.begin_run(self.request_stop)
            # Again, because some may be attributes that were set after the constructor.
            check_methods(self, _PLAIN_METHODS)
            self._claim(processes, stop)
            self._program.phase = "handshake"
            self._wait_for_handshake()
            self._program.phase = "bringing up"
            bring_up(self._lifecycle_nodes(), self._is_stopping, self.logger)
            self._name_undeclared()
            self._watch_time()
            self._program.phase = "running"
            self._run_loop(
                self.backend.executor,
                self.node_freq_hz,
                self.main_loop,
                self._is_stopping,
                self.loop_stats,
                self._look_after,
            )
        except BaseException as error:
            note_interruption(self.backend, error)
            self.loop_stats.end_tick()
            failure = self._shut_down(processes, stop)
            if not is_wish(error, stop):
                raise
        else:
            failure = self._shut_down(processes, stop)
        if failure is not None:
            raise failure
        if self._processes is not None and self._processes.exit_status:
            raise SystemExit(self._processes.exit_status)

    def start_main_loop(self, processes: ChildProcesses | None = None) -> None:
        """Call `start_main_loop_timer`. This is its older name."""
        self.start_main_loop_timer(processes)

    def destroy_node(self) -> None:
        """Close the connection of this manager.

        The main loop does so itself; a second call does nothing.
        """
        self.backend.close()
        if not self._has_started:
            end_recording(self._recording, self.backend, None)

    def _stop_now(self) -> None:
        self._stop_requests.append(True)
        self.backend.call_soon(_nothing)

    def _claim(self, processes: ChildProcesses | None, stop: StopSignals | None) -> None:
        if isinstance(processes, ChildProcesses):
            self._processes = processes
            on_required_end = self.request_stop
            if stop is not None and any(child.is_required for child in processes.values()):
                stop.prepare_for_children()
                on_required_end = stop.child_has_ended
            processes.claim(self.logger, on_required_end)
            if self._stop_requests:
                # Asked for before it was known whom else this concerns.
                processes.stopping_soon()
        elif processes:
            raise TypeError(f"{processes!r} is not a return value of register_multiprocess_nodes")

    def _name_undeclared(self) -> None:
        """Warn of parameters from outside that no node has declared."""
        if are_inherited():
            return
        # Parameters may be declared in `on_configure`. Each child warns of its own.
        later = [n._key for n in self._lifecycle_nodes() if n.get_state() is State.UNCONFIGURED]
        self._undeclared_later = bool(later)
        for line in given_parameters().unused([*later, *(self._processes or ())]):
            self.logger.warning(line)

    def _lifecycle_nodes(self) -> list[LifecycleNode]:
        return [node for node in self.nodes.values() if isinstance(node, LifecycleNode)]

    def _wait_for_handshake(self) -> None:
        timeout_s = self._handshake_timeout_s
        if timeout_s is None and has_no_signals(self.backend):
            timeout_s = _VIRTUAL_HANDSHAKE_S
        self._handshake.wait(
            self.backend, self._is_pending, self._is_stopping, timeout_s, self._not_active_yet
        )

    def _name_threads_left(self) -> None:
        name_threads_left(self._known_threads, self.logger)

    def _is_pending(self) -> bool:
        answer = self.handshake()
        check_answer(answer, f"{type(self).__name__}.handshake")
        return answer is False

    def _not_active_yet(self) -> str:
        """Return a hint for a rule that waits for a lifecycle node to become active."""
        names = ", ".join(node._label for node in self._lifecycle_nodes())
        return f" (brought up only after the handshake: {names})" if names else ""

    def _watch_time(self) -> None:
        self._clock_watch = ClockWatch(self.backend.executor.clock, self.logger)
        if self._log_freq:
            self._frequency_log = FrequencyLog(self.backend.clock, self.loop_stats, self.logger)

    def _look_after(self) -> None:
        self.loop_stats.digest_if_many()
        if self._undeclared_later:
            self._name_undeclared()
        self._clock_watch.check()
        if self._frequency_log is not None:
            self._frequency_log.check()

    def _shut_down(
        self, processes: ChildProcesses | None, stop: StopSignals | None
    ) -> BaseException | None:
        self._program.phase = "stopping"
        self.backend.executor.begin_clean_up()
        if self._processes is not None:
            self._processes.stopping_soon()
        return run_steps(
            [
                ("lifecycle nodes", lambda: take_down(self._lifecycle_nodes(), self.logger)),
                ("child processes", lambda: shutdown_multiprocess_nodes(processes)),
                ("release_resources", self.release_resources),
                ("destroy_node", self.destroy_node),
                ("backend", self.backend.close),
                ("threads", partial(run_aside, self.backend, self._name_threads_left)),
            ],
            self.logger,
            stop,
            ("the backend's world", self.backend.end_run),
        )


for _name in (
    *BaseManager.__annotations__,
    *("_has_started", "_handshake", "_processes", "_stop_requests"),
):
    if not hasattr(BaseManager, _name):
        setattr(BaseManager, _name, SetByConstructor(_ARGUMENTS, _name))


def _is_duration(value: object) -> bool:
    return isinstance(value, (int, float)) and value >= 0


def _nothing() -> None:
    """Do nothing: called to wake the main loop."""
