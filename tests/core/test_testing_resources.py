"""What the kits measure of a process."""

import time

from rosbase.testing.resources import wanted_cpu_s

SPAN_S = 0.3


def wanted_while(spins: bool) -> float:
    before_s = wanted_cpu_s()
    end_s = time.monotonic() + SPAN_S
    while spins and time.monotonic() < end_s:
        pass
    time.sleep(max(0.0, end_s - time.monotonic()))
    return wanted_cpu_s() - before_s


def test_a_busy_loop_wants_all_of_a_processor_however_busy_the_machine_is() -> None:
    assert wanted_while(spins=True) > SPAN_S * 0.8
    assert wanted_while(spins=False) < SPAN_S / 2
