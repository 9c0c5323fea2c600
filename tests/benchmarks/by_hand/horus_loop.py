"""A fixed rate as one gets it from HORUS. Prints as `timer_loop` does.

With a first argument `same`, its scheduler runs at the rate of the node.
"""

import sys
import time

import horus


def main(rate_hz: float, warm_up: int, ticks: int, **options: float) -> None:
    starts: list[int] = []
    before_ns = 0

    def tick(node: horus.Node) -> None:
        nonlocal before_ns
        starts.append(time.monotonic_ns())
        if len(starts) == warm_up:
            before_ns = time.process_time_ns()
        if len(starts) == warm_up + ticks:
            print(time.process_time_ns() - before_ns, *starts[warm_up:])
            node.request_stop()

    horus.run(horus.Node(name="loop", tick=tick, rate=rate_hz), **options)


if __name__ == "__main__":
    *same, rate, warm_up, ticks = sys.argv[1:]
    options = {"tick_rate": float(rate)} if same else {}
    main(float(rate), int(warm_up), int(ticks), **options)
