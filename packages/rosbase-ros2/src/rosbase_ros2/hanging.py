"""End a process that hangs in DDS, where no Python code can run any more.

When Fast DDS 2.14 destroys the participant of a process, it waits for its callbacks of discovery,
and holds the lock that they need. If another program appears or goes at that moment, it waits for
ever. rclpy holds the GIL meanwhile, so no handler of a signal runs: only SIGKILL would end the
process.
"""

import faulthandler
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["end_if_hanging"]

# launch sends SIGTERM after 5 s, and SIGKILL after 10.
_LONGEST_S = 4.0
# It takes 0.2 ms while the machine does nothing else.
_LONGEST_EACH_S = 0.01
_STDERR = 2


@contextmanager
def end_if_hanging(count: int) -> Iterator[None]:
    """End the process with status 1 and a traceback on stderr if the context lasts too long.

    faulthandler needs no GIL. It has one timer for the process: one that the program has started
    itself is stopped.

    Args:
        count: How many publishers, subscriptions and the like are destroyed.
    """
    limit_s = _LONGEST_S + _LONGEST_EACH_S * count
    faulthandler.dump_traceback_later(limit_s, exit=True, file=_STDERR)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()
