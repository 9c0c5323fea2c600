"""What a contract promises, and the failure that names the promise and the page about it."""

from attrs import frozen

__all__ = ["BrokenPromiseError", "Promise"]


class BrokenPromiseError(AssertionError):
    """An implementation does not do what its contract says."""


@frozen
class Promise:
    """One sentence of a contract, which a check of the kit holds an implementation to."""

    name: str
    """Words with hyphens, such as `stop-is-bounded`; also its place on the page."""
    sentence: str
    """What is promised, as a statement."""
    page: str
    """The page of the documentation that says more, such as `plugins/transport-contract`."""

    def require(self, holds: object, seen: str) -> None:
        """Fails, unless it holds.

        Args:
            holds: Whether it does.
            seen: What happened instead, with figures.

        Raises:
            BrokenPromiseError: It does not hold.
        """
        if not holds:
            raise self.broken(seen)

    def broken(self, seen: str) -> BrokenPromiseError:
        """The failure that says so."""
        return BrokenPromiseError(
            f"broken promise: {self.name}\n"
            f"  promised: {self.sentence}\n"
            f"  seen:     {seen}\n"
            f"  more:     docs/{self.page}.md#{self.name}"
        )
