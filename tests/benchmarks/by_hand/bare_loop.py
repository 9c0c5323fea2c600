"""A fixed rate without anything: sleep until the next deadline. Prints as `timer_loop` does."""

import sys
import time


def main(rate_hz: float, ticks: int) -> None:
    starts: list[int] = []
    deadline_s = time.monotonic()
    before_ns = time.process_time_ns()
    while len(starts) < ticks:
        starts.append(time.monotonic_ns())
        deadline_s += 1.0 / rate_hz
        left_s = deadline_s - time.monotonic()
        if left_s > 0:
            time.sleep(left_s)
    print(time.process_time_ns() - before_ns, *starts)


if __name__ == "__main__":
    main(float(sys.argv[1]), int(sys.argv[2]))
