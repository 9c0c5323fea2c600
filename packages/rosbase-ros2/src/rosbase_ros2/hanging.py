"""End a process that hangs in DDS, where no Python code can run any more.

Fast DDS 2.14 waits for its discovery callbacks when it destroys the participant of a process, and
holds the lock that they need. If another program starts or ends at that moment, it waits for ever.
rclpy holds the GIL meanwhile, so no signal handler runs: only SIGKILL would end the process.
"""

import faulthandler
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["end_if_hanging"]

# launch sends SIGTERM after 5 s, and SIGKILL after 10.
_LONGEST_S = 4.0
# For each publisher and the like. Destroying one takes 0.2 ms on an idle machine.
_LONGEST_EACH_S = 0.01
_STDERR = 2


@contextmanager
def end_if_hanging(count: int) -> Iterator[None]:
    """End the process with status 1 and a traceback on stderr if the context lasts too long.

    faulthandler needs no GIL, but has only one timer for the process. If the program has started
    it too, this stops it.

    Args:
        count: How many publishers, subscriptions and the like are destroyed.
    """
    limit_s = _LONGEST_S + _LONGEST_EACH_S * count
    faulthandler.dump_traceback_later(limit_s, exit=True, file=_STDERR)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()
