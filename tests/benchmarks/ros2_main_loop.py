"""The manager's loop on ROS 2 beside a timer of rclpy and a bare loop.

`nox -s bench` runs it and prints a table. Each row is a process of its own. The ratios are
what matters: machines are noisy, so the rows take turns, and the medians of the turns count; of
ratios, those of the turn's own.

- rclpy timer: `create_timer` and `rclpy.spin`
- manager: `BaseManager` on the backend `ros2`, with handlers that do the same
- manager, precise: the same with `timing="precise"`
- bare loop: sleep until the next deadline, without ROS
"""

import os
from functools import partial

from benchmarks.rig.loops import Turn, manager_row, measure, print_table, row_by_hand
from benchmarks.rig.turns import take_turns
from support.ros_domain import own_domain

ROWS = {
    "rclpy timer": row_by_hand("timer_loop.py"),
    "manager": manager_row("ros2", "normal"),
    "manager, precise": manager_row("ros2", "precise"),
    "bare loop": row_by_hand("bare_loop.py"),
}
TURNS = 9
RATES_HZ = (200, 1000)


def turn(rate_hz: int, name: str) -> Turn:
    """One turn of a row."""
    return measure(ROWS[name], rate_hz)


def main() -> None:
    """Prints the tables."""
    os.environ |= {
        "ROS_DOMAIN_ID": str(own_domain()),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }
    for rate_hz in RATES_HZ:
        rows = take_turns(partial(turn, rate_hz), ROWS, TURNS)
        print_table(f"{rate_hz} Hz", rows, "rclpy timer")


if __name__ == "__main__":
    main()
