"""The manager of a random program. It notes all that its callbacks see."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from rosbase import (
    BaseHandlers,
    BaseManager,
    BaseNode,
    CallbackReturn,
    LifecycleNode,
    RosbaseLogger,
)
from rosbase.contracts.backend import Backend
from rosbase.contracts.transport import (
    OnFrame,
    Transport,
    TransportContext,
    TransportHealth,
    TransportState,
)
from rosbase.device.conducted import conducted_transport
from rosbase.errors import RosbaseError
from rosbase.messages import Vector3
from rosbase.messages.std_srvs import SetBool
from rosbase.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from support.random_programs import TICK_HZ, Act, Acts, RandomProgram

__all__ = ["RandomManager", "run_program"]

_LABELS = ("configure", "activate", "deactivate", "cleanup")
# A message of a callback for a message lets fewer follow, so that it ends.
_MOST_HOPS = 3
_SERVICE_S = 0.05
_FOR_THREADS_S = 0.0005


def run_program(program: RandomProgram, backend: Backend) -> list[Any]:
    """Run a program to its end; return all that its callbacks saw.

    Args:
        program: The program.
        backend: Its connection. Its clock may be recorded, or replayed.
    """
    manager = RandomManager(program, backend)
    with manager.helped():
        manager.start_main_loop_timer()
    return manager.seen


class Ticks(BaseHandlers):
    """Does what the program does in each tick."""

    manager: Any

    def handle(self) -> None:
        manager = self.manager
        manager.has_ticked(self.timestamp)
        # Virtual time leaves threads no time for what they do.
        time.sleep(_FOR_THREADS_S)
        manager.see("tick", self.timestamp)
        manager.do(manager.program.on_tick, _MOST_HOPS)
        if self.timestamp + 1 >= manager.program.ticks:
            manager.request_stop()


class Managed(LifecycleNode):
    """A lifecycle node whose callbacks do what the program says."""

    manager: Any

    def on_configure(self, previous_state: Any) -> CallbackReturn:
        return self._do("configure")

    def on_activate(self, previous_state: Any) -> CallbackReturn:
        return self._do("activate")

    def on_deactivate(self, previous_state: Any) -> CallbackReturn:
        return self._do("deactivate")

    def on_cleanup(self, previous_state: Any) -> CallbackReturn:
        return self._do("cleanup")

    def _do(self, what: str) -> CallbackReturn:
        manager = self.manager
        manager.see("transition", what)
        manager.do(manager.program.on_transition, 1)
        return CallbackReturn.SUCCESS


class Body(BaseNode):
    """Has the timers, topics, services and parameters of the program."""

    def __init__(self, manager: Any = None, *args: Any, **kwargs: Any) -> None:
        super().__init__(manager, *args, **kwargs)
        program: RandomProgram = manager.program
        self.publishers: list[Any] = []
        self.latest_values: list[Any] = []
        for number, topic in enumerate(program.topics):
            name = f"topic_{number}"
            qos = QoSProfile(
                topic.depth,
                durability=DurabilityPolicy["TRANSIENT_LOCAL" if topic.is_latched else "VOLATILE"],
                reliability=ReliabilityPolicy["RELIABLE" if topic.is_reliable else "BEST_EFFORT"],
            )
            self.publishers.append(self.create_publisher(Vector3, name, qos))
            self.create_subscription(
                Vector3, name, partial(manager.hear, number, topic.on_message), qos
            )
            self.latest_values.append(self.latest(Vector3, name))
        self.timers = [
            self.create_timer(period_ms / 1000, partial(manager.time, number, acts))
            for number, (period_ms, acts) in enumerate(program.timers)
        ]
        for number, acts in enumerate(program.services):
            self.create_service(SetBool, f"service_{number}", partial(manager.serve, number, acts))
        # One more, which nobody serves.
        self.clients = [
            self.create_client(SetBool, f"service_{number}")
            for number in range(len(program.services) + 1)
        ]
        for number in range(2):
            self.declare_parameter(f"number_{number}", 0)
        self.add_on_set_parameters_callback(manager.judge)
        self.add_post_set_parameters_callback(manager.note_parameters)


class RandomManager(BaseManager):
    """Runs a random program."""

    def __init__(self, program: RandomProgram, backend: Backend) -> None:
        self.program = program
        self.seen: list[Any] = []
        """What the callbacks saw, in their order."""
        self._tick = 0
        self._ticked = threading.Condition()
        self._is_over = False
        super().__init__(
            "random",
            {"body": Body, "managed": Managed},
            handlers_class=Ticks,
            node_freq_hz=TICK_HZ,
            backend=backend,
        )
        self._last = 0.5
        self._transport = self._make_transport()
        self._transport.open()
        self._transport.start(self.take_frame)

    def release_resources(self) -> None:
        """Close the transport."""
        self._let_threads_end()
        self._transport.stop()
        self.see("health", self._transport.health.frames)
        self._transport.close()

    # What callbacks do.

    def see(self, what: str, *values: Any) -> None:
        """Note what a callback sees."""
        self.seen.append((what, *values))

    def do(self, acts: Acts, hops: int) -> None:
        """Do what the program says, on the thread that runs it."""
        for act in acts:
            getattr(self, f"_{act.what}")(act, hops)

    def hear(self, number: int, acts: Acts, message: Vector3) -> None:
        """Handle a message."""
        self.see("message", number, message.x, message.y, message.z)
        self._last = self._last / 2 + message.x
        if message.y > 0:
            self.do(acts, int(message.y))

    def time(self, number: int, acts: Acts) -> None:
        """Handle a timer."""
        self.see("timer", number)
        self.do(acts, _MOST_HOPS)

    def serve(self, number: int, acts: Acts, request: SetBool.Request) -> SetBool.Response:
        """Answer a request."""
        self.see("request", number, request.data)
        self.do(tuple(act for act in acts if not act.what.startswith("call")), 1)
        if not request.data and number == 0:
            raise ValueError("it does not like that")
        return SetBool.Response(request.data, f"{self._last}")

    def judge(self, parameters: Any) -> Any:
        """Refuse some values of parameters."""
        from rosbase import SetParametersResult

        is_good = all(parameter.value != 7 for parameter in parameters)
        return SetParametersResult(successful=is_good, reason="" if is_good else "seven")

    def note_parameters(self, parameters: Any) -> None:
        """Handle new values of parameters."""
        self.see("parameters", *((p.name, p.value) for p in parameters))
        self.do(self.program.on_parameter, 1)

    def take_frame(self, frame: bytes, stamp_ns: int) -> bool:
        """Take a frame of the transport, on its thread."""
        self.see("frame", frame, stamp_ns)
        self.do(self.program.on_frame, 2)
        return True

    @property
    def body(self) -> Body:
        """The node."""
        return self.node(Body)

    def _publish(self, act: Act, hops: int) -> None:
        number = act.number % len(self.program.topics)
        publisher = self.body.publishers[number]
        publisher.publish(Vector3(self._last + act.value, float(hops - 1), float(act.value)))

    def _log(self, act: Act, _: int) -> None:
        self.logger.info(f"says {act.value}, with {self._last!r}")

    def _read_monotonic(self, _: Act, __: int) -> None:
        self.see("monotonic", self.backend.executor.clock.monotonic_ns())

    def _read_date(self, _: Act, __: int) -> None:
        self.see("date", self.body.get_clock().now_ns())

    def _reset_timer(self, act: Act, _: int) -> None:
        if self.body.timers:
            self.body.timers[act.number % len(self.body.timers)].reset()

    def _cancel_timer(self, act: Act, _: int) -> None:
        if self.body.timers:
            self.body.timers[act.number % len(self.body.timers)].cancel()

    def _new_timer(self, act: Act, _: int) -> None:
        if len(self.body.timers) < 6:
            handle = partial(self.time, len(self.body.timers), ())
            self.body.timers.append(self.body.create_timer(0.01 + abs(act.value) / 500, handle))

    def _set_parameter(self, act: Act, _: int) -> None:
        result = self.body.set_parameter(f"number_{act.number % 3}", act.value)
        self.see("set", result.successful, result.reason)

    def _transition(self, act: Act, _: int) -> None:
        node = self.node(Managed)
        try:
            answer = node.request_transition(0, _LABELS[act.number % len(_LABELS)])
            self.see("transitioned", answer.name, node.get_state().label)
        except RosbaseError as error:
            self.see("refused", str(error))

    def _call(self, act: Act, _: int) -> None:
        clients = self.body.clients
        client = clients[act.number % len(clients)]
        try:
            answer = client.call(SetBool.Request(act.value > 0), _SERVICE_S)
            self.see("answer", answer.success, answer.message)
        except RosbaseError as error:
            self.see("no answer", str(error))

    def _call_async(self, act: Act, _: int) -> None:
        clients = self.body.clients
        client = clients[act.number % len(clients)]
        future = client.call_async(SetBool.Request(act.value > 0), _SERVICE_S)
        future.add_done_callback(self._note_answer)

    def _note_answer(self, future: Any) -> None:
        self.see("answered", str(future.exception() or future.result().message))

    def _post(self, act: Act, _: int) -> None:
        self.backend.call_soon(partial(self.see, "posted", act.value))

    def _look_at_latest(self, act: Act, _: int) -> None:
        latest = self.body.latest_values[act.number % len(self.program.topics)]
        self.see("latest", latest.value and latest.value.x, latest.age_s)

    def _throttle(self, act: Act, _: int) -> None:
        self.see("due", self.logger.due("key", 0.03 + act.number / 100))

    def _statistics(self, _: Act, __: int) -> None:
        stats = self.loop_stats
        self.see("statistics", stats.ticks, stats.overruns)

    # Outside.

    def has_ticked(self, tick: int) -> None:
        """Let threads do what they do after a tick has begun."""
        with self._ticked:
            self._tick = tick
            self._ticked.notify_all()

    def wait_for_tick(self, tick: int) -> bool:
        """Wait until a tick has begun; return False if it never does."""
        with self._ticked:
            self._ticked.wait_for(lambda: self._tick >= tick or self._is_over)
            return not self._is_over

    @contextmanager
    def helped(self) -> Iterator[None]:
        """Run the thread of the user while the block runs."""
        thread = threading.Thread(target=self._act_outside, name="user")
        thread.start()
        try:
            yield
        finally:
            self._let_threads_end()
            thread.join()

    def _let_threads_end(self) -> None:
        with self._ticked:
            self._is_over = True
            self._ticked.notify_all()

    def _act_outside(self) -> None:
        for one in self.program.thread:
            if not self.wait_for_tick(one.tick):
                return
            self._do_outside(one.act)

    def _do_outside(self, act: Act) -> None:
        node, body = self.node(Managed), self.body
        try:
            if act.what == "publish":
                number = act.number % len(self.program.topics)
                body.publishers[number].publish(Vector3(act.value / 3, 1.0, -1.0))
            elif act.what == "log":
                RosbaseLogger("user").info(f"a thread says {act.value}")
            elif act.what == "transition":
                node.request_transition(0, _LABELS[act.number % len(_LABELS)])
            elif act.what == "post":
                self.backend.call_soon(partial(self.see, "posted outside", act.value))
            elif act.what == "reset_timer":
                if body.timers:
                    body.timers[act.number % len(body.timers)].reset()
            else:
                clients = body.clients
                clients[act.number % len(clients)].call(SetBool.Request(act.value > 0), _SERVICE_S)
        except (RosbaseError, RuntimeError):
            # Such as a transition that the state does not allow, or one that the recording does
            # not have, because the program had ended.
            pass

    def _make_transport(self) -> Transport:
        make = partial(PacedTransport, self.program.frames, self.wait_for_tick)
        context = TransportContext(self.backend.executor.clock, RosbaseLogger("transport"))
        conductor = self.backend.conductor
        if conductor is None:
            return make(context)
        return conducted_transport(conductor, "paced", make, context)


class PacedTransport(Transport):
    """Has a frame after some ticks, on a thread of its own."""

    def __init__(
        self, ticks: tuple[int, ...], wait: Callable[[int], bool], context: TransportContext
    ) -> None:
        self._ticks = ticks
        self._wait = wait
        self._clock = context.clock
        self._state = TransportState.CLOSED
        self._frames = 0
        self._is_stopped = threading.Event()
        self._thread: threading.Thread | None = None

    def open(self) -> None:
        self._state = TransportState.CONNECTED

    def start(self, on_frame: OnFrame) -> None:
        self._thread = threading.Thread(target=self._run, args=(on_frame,), name="paced")
        self._thread.start()

    def stop(self) -> None:
        self._is_stopped.set()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join()

    def close(self) -> None:
        self.stop()
        self._state = TransportState.CLOSED

    @property
    def is_open(self) -> bool:
        return self._state is TransportState.CONNECTED

    @property
    def health(self) -> TransportHealth:
        return TransportHealth(self._state, self._frames)

    def _run(self, on_frame: OnFrame) -> None:
        for number, tick in enumerate(self._ticks):
            if not self._wait(tick) or self._is_stopped.is_set():
                return
            on_frame(bytes([number]), self._clock.now_ns())
            self._frames += 1
