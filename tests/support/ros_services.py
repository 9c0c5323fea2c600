"""Services of plain rclpy for tests: a node with a context and a thread of its own."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from std_srvs.srv import SetBool, Trigger

from support.ros import TIMEOUT_S, ros_context, spinning


class Plain:
    """A node of plain rclpy, on the other side of the network."""

    def __init__(self, context: Any, name: str) -> None:
        self.node: Any = rclpy.create_node(name, context=context)
        self.executor: Any = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self.served: list[Any] = []
        self.delay = threading.Event()
        self.delay.set()

    def serve(self, kind: Any, name: str, **values: Any) -> Any:
        """Has a service that answers these values, as soon as `delay` is set."""

        def answer(request: Any, response: Any) -> Any:
            self.served.append(request)
            assert self.delay.wait(TIMEOUT_S)
            for field, value in values.items():
                setattr(response, field, value)
            return response

        return self.node.create_service(kind, name, answer)

    def ask(self, kind: Any, name: str, **values: Any) -> Any:
        """Sends a request as soon as the service is there; gives the future of the answer."""
        client = self.node.create_client(kind, name)
        assert client.wait_for_service(TIMEOUT_S), f"{name} is not there"
        return client.call_async(kind.Request(**values))

    def ask_for_bool(self, name: str, data: bool) -> Any:
        """Asks a service of type SetBool."""
        return self.ask(SetBool, name, data=data)

    def trigger(self, name: str) -> Any:
        """Asks a service of type Trigger."""
        return self.ask(Trigger, name)


@contextmanager
def plain_node(name: str = "plain") -> Iterator[Plain]:
    """A node of plain rclpy that a thread spins."""
    with ros_context() as context:
        plain = Plain(context, name)
        with spinning(lambda: plain.executor.spin_once(timeout_sec=0.05), "plain node"):
            yield plain
        plain.executor.shutdown()
        plain.node.destroy_node()


def on_thread(work: Callable[[], object]) -> tuple[threading.Thread, list[Any]]:
    """Does it on a thread; gives the thread, and a list for the result or the exception."""
    found: list[Any] = []

    def run() -> None:
        try:
            found.append(work())
        except Exception as error:
            found.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    return thread, found
