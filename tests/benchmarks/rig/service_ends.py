"""The two ends of a service in programs of rosbase, as `by_hand/service_ends.py` has them."""

import sys
from typing import Any

from benchmarks.rig.counted_calls import CountedCalls
from rosbase import BaseHandlers, BaseManager, BaseNode
from rosbase.messages.std_srvs import SetBool


class Server(BaseNode):
    """Answers until it is ended."""

    def __init__(self, counted: CountedCalls) -> None:
        super().__init__(node_name="service", backend="ros2")
        self.counted = counted
        self.create_service(SetBool, "flip", self.answer)

    def answer(self, request: SetBool.Request) -> SetBool.Response:
        self.counted.count()
        return SetBool.Response(success=request.data)


class Caller(BaseNode):
    """Has a client."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.client = self.create_client(SetBool, "flip")

    def call_once(self) -> None:
        assert self.client.call(SetBool.Request(data=True)).success


class Handlers(BaseHandlers):
    """Calls once in each tick, or without a rate as often as it shall in one."""

    def __init__(
        self, manager: Any = None, *, counted: Any = None, rate_hz: float = 0.0, **kwargs: Any
    ) -> None:
        super().__init__(manager, **kwargs)
        self.counted, self.rate_hz = counted, rate_hz

    def handle(self) -> None:
        call_once = self.node(Caller).call_once
        self.counted.make(call_once)
        while not (self.rate_hz or self.counted.are_done):
            self.counted.make(call_once)
        if self.counted.are_done:
            self.manager.request_stop()


def run(end: str, rate_hz: float, counted: CountedCalls) -> None:
    """Run one of the two ends."""
    if end == "service":
        Server(counted).start_spin_standalone()
    else:
        BaseManager(
            "client",
            {"caller": Caller},
            handlers_class=Handlers,
            node_freq_hz=rate_hz or 100,
            backend="ros2",
            counted=counted,
            rate_hz=rate_hz,
        ).start_main_loop_timer()


if __name__ == "__main__":
    run(sys.argv[1], float(sys.argv[2]), CountedCalls(int(sys.argv[3]), int(sys.argv[4])))
