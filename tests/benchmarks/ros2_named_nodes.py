"""The CPU for a message of three lifecycle nodes of one manager, beside that of one.

`nox -s bench -- ros2_named_nodes` runs it and prints a table. A process of plain rclpy publishes;
the manager is another process. In the row "one", its lifecycle node subscribes to three topics; in
the row "three", each of three lifecycle nodes to one. The rows take turns, and the median of the
turns' ratios counts.
"""

import os
import random
import statistics
import subprocess
import sys
import time

TURNS = 7
MESSAGES = 3000
RATE_HZ = 500.0
PATIENCE_S = 60.0
TOPICS = ("a", "b", "c")

PUBLISHER = f"""
import time, rclpy
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("publisher")
ends = [node.create_publisher(String, topic, 100) for topic in {TOPICS!r}]
while not all(end.get_subscription_count() for end in ends):
    time.sleep(0.05)
time.sleep(1.0)
start_s = time.monotonic()
for number in range({MESSAGES}):
    time.sleep(max(0.0, start_s + number / {RATE_HZ} - time.monotonic()))
    ends[number % 3].publish(String(data=str(number)))
time.sleep(1.0)
"""

MANAGER = f"""
import sys, time
from rosbase import BaseHandlers, BaseManager, LifecycleNode
from rosbase.messages import String

heard = []

class Listener(LifecycleNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        for topic in {TOPICS!r} if self.name == "robot" else [self.name]:
            self.create_subscription(String, topic, self.keep, 100)

    def keep(self, message):
        if not heard:
            heard.append(time.process_time())
        heard.append(message.data)

class Handlers(BaseHandlers):
    def handle(self):
        if len(heard) > {MESSAGES}:
            print((time.process_time() - heard[0]) / {MESSAGES} * 1e6)
            self.manager.request_stop()

names = ["robot"] if sys.argv[1] == "one" else {TOPICS!r}
nodes = dict.fromkeys(names, Listener)
manager = BaseManager("robot", nodes, handlers_class=Handlers, node_freq_hz=10, backend="ros2")
manager.start_main_loop_timer()
"""


def measure(row: str) -> float:
    """CPU for each message, in microseconds, of all threads of the manager's process."""
    os.environ["ROS_DOMAIN_ID"] = str(random.SystemRandom().randint(1, 100))
    publisher = subprocess.Popen([sys.executable, "-c", PUBLISHER])
    try:
        done = subprocess.run(
            [sys.executable, "-c", MANAGER, row],
            stdout=subprocess.PIPE,
            text=True,
            check=True,
            timeout=PATIENCE_S,
        )
    finally:
        publisher.kill()
        publisher.wait()
    return float(done.stdout)


def main() -> None:
    """Take turns, and print the table."""
    os.environ |= {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    turns: dict[str, list[float]] = {"one": [], "three": []}
    for number in range(TURNS):
        for row in list(turns)[:: 1 if number % 2 else -1]:
            turns[row].append(measure(row))
            time.sleep(0.2)
    for row, figures in turns.items():
        print(f"{row:6} {statistics.median(figures):6.1f} us of CPU for each message")
    ratios = [three / one for one, three in zip(turns["one"], turns["three"], strict=True)]
    print(f"three / one {statistics.median(ratios):.2f}")


if __name__ == "__main__":
    main()
