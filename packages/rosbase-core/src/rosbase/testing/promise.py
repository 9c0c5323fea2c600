"""Promises of a contract, and the failure that names a promise and its page."""

from attrs import frozen

__all__ = ["BrokenPromiseError", "Promise"]


class BrokenPromiseError(AssertionError):
    """An implementation breaks its contract."""


@frozen
class Promise:
    """One sentence of a contract, checked by the kit."""

    name: str
    """Words with hyphens, such as `stop-is-bounded`; also the anchor on the page."""
    sentence: str
    """The promise, as a statement."""
    page: str
    """Page of the documentation about it, such as `plugins/transport-contract`."""

    def require(self, holds: object, seen: str) -> None:
        """Fail unless the promise holds.

        Args:
            holds: Whether the promise holds.
            seen: The event that happened instead, with figures.

        Raises:
            BrokenPromiseError: The promise does not hold.
        """
        if not holds:
            raise self.broken(seen)

    def broken(self, seen: str) -> BrokenPromiseError:
        """Return the failure that names the promise."""
        return BrokenPromiseError(
            f"broken promise: {self.name}\n"
            f"  promised: {self.sentence}\n"
            f"  seen:     {seen}\n"
            f"  more:     docs/{self.page}.md#{self.name}"
        )
