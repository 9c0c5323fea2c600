"""A program as any user of ROS writes it: walks a lifecycle node around, prints what it sees.

It knows rclpy and lifecycle_msgs, and nothing of rosbase.
"""

import json
import sys
from typing import Any

import rclpy
from lifecycle_msgs import msg, srv

# An id and a label for each request; the one that counts differs.
WALK = [(1, ""), (3, "activate"), (0, "deactivate"), (2, ""), (0, "shutdown")]
EVENTS = 10


def main(target: str) -> None:
    """Walks, and prints one line of JSON."""
    rclpy.init()
    node: Any = rclpy.create_node("walker")
    change = node.create_client(srv.ChangeState, f"{target}/change_state")
    state = node.create_client(srv.GetState, f"{target}/get_state")
    events: list[Any] = []
    node.create_subscription(msg.TransitionEvent, f"{target}/transition_event", events.append, 10)
    assert change.wait_for_service(20.0)
    assert state.wait_for_service(20.0)
    # Whoever started this program knows when the subscription is connected.
    print("ready", flush=True)
    sys.stdin.readline()

    def call(client: Any, request: Any) -> Any:
        future = client.call_async(request)
        rclpy.spin_until_future_complete(node, future, timeout_sec=20.0)
        return future.result()

    steps = []
    for transition_id, label in WALK:
        wanted = msg.Transition(id=transition_id, label=label)
        success = call(change, srv.ChangeState.Request(transition=wanted)).success
        steps.append([success, call(state, srv.GetState.Request()).current_state.label])
    while len(events) < EVENTS:
        rclpy.spin_once(node, timeout_sec=1.0)
    seen = [[e.transition.id, e.start_state.label, e.goal_state.label] for e in events]
    print(json.dumps({"steps": steps, "events": seen}), flush=True)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main(sys.argv[1])
