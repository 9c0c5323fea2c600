"""A right to act that exactly one of several threads gets."""

__all__ = ["Claim"]


class Claim:
    """Lets either the main loop begin a request, or its timeout give it up."""

    __slots__ = ("_entries",)

    def __init__(self) -> None:
        # To pop is one step, whatever other threads do; a lock could be held when a signal comes.
        self._entries = [True]

    def take(self) -> bool:
        """Return whether the caller is the first. Call it from any thread."""
        try:
            self._entries.pop()
        except IndexError:
            return False
        return True
