"""Answers to a client that the service has not discovered yet: rmw drops them after 100 ms."""

import time
import warnings
from collections.abc import Callable
from typing import Any

import pytest

from rosbase.messages.std_srvs import Trigger
from rosbase_ros2.backend import Ros2Backend
from support.ros import spin_until
from support.waiting import wait_until

LOST = "failed to send response (timeout): client will not receive response"
DROPPED_FOR_S = 0.11


class Rmw:
    """Sends the answers of a service, and drops the first ones as rmw does."""

    def __init__(self, send: Callable[[Any, Any], object], drops: int) -> None:
        self.send, self.drops, self.tries = send, drops, 0

    def __call__(self, response: Any, header: Any) -> None:
        self.tries += 1
        if self.tries <= self.drops:
            time.sleep(DROPPED_FOR_S)
            warnings.warn(LOST, RuntimeWarning, stacklevel=1)
        else:
            self.send(response, header)


@pytest.mark.parametrize("action", ["error", "ignore"])
def test_an_answer_that_was_dropped_is_sent_again(
    context: Any, backend: Ros2Backend, action: Any
) -> None:
    import rclpy
    from std_srvs.srv import Trigger as RosTrigger

    service: Any = backend.create_service(
        Trigger, "late", lambda request: Trigger.Response(success=True)
    )
    rmw = service._send = Rmw(service._send, drops=2)
    node: Any = rclpy.create_node("asker", context=context)
    client = node.create_client(RosTrigger, "late")
    wait_until(client.service_is_ready, "the service")
    with warnings.catch_warnings():
        warnings.simplefilter(action, RuntimeWarning)
        future = client.call_async(RosTrigger.Request())
        spin_until(backend, lambda: rmw.tries)
        executor = rclpy.executors.SingleThreadedExecutor(context=context)
        executor.add_node(node)
        executor.spin_until_future_complete(future, 10.0)
        wait_until(lambda: rmw.tries >= 3, "the third try")
    assert future.result().success
    executor.shutdown()
    node.destroy_node()
    backend.destroy_service(service)
