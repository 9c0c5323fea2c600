"""A fixed rate without anything: sleep until the next deadline. Prints as `timer_loop` does."""

import sys
import time


def main(rate_hz: float, warm_up: int, ticks: int) -> None:
    starts: list[int] = []
    deadline_s = time.monotonic()
    while len(starts) < warm_up + ticks:
        starts.append(time.monotonic_ns())
        if len(starts) == warm_up:
            before_ns = time.process_time_ns()
        deadline_s += 1.0 / rate_hz
        left_s = deadline_s - time.monotonic()
        if left_s > 0:
            time.sleep(left_s)
    print(time.process_time_ns() - before_ns, *starts[warm_up:])


if __name__ == "__main__":
    main(float(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
