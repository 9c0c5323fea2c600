"""What the kits measure of a process."""

import threading
import time
from collections.abc import Callable

from rosbase.testing.resources import wanted_cpu_s

SPAN_S = 0.3


def wanted_beside(work: Callable[[threading.Event], object]) -> float:
    """What a thread wants of a processor for a while."""
    is_over = threading.Event()
    thread = threading.Thread(target=work, args=(is_over,))
    thread.start()
    before_s = wanted_cpu_s()
    time.sleep(SPAN_S)
    wanted_s = wanted_cpu_s() - before_s
    is_over.set()
    thread.join()
    return wanted_s


def spin(is_over: threading.Event) -> None:
    while not is_over.is_set():
        pass


def test_a_busy_loop_wants_all_of_a_processor_however_busy_the_machine_is() -> None:
    assert wanted_beside(spin) > SPAN_S * 0.8
    assert wanted_beside(threading.Event.wait) < SPAN_S / 5
