"""Evenly spaced stamps for events that arrived together but did not happen at once."""

__all__ = ["spread"]


def spread(count: int, after_ns: int, until_ns: int, widest_ns: int | None = None) -> range:
    """Return `count` stamps that rise evenly, later than `after_ns`, the last at `until_ns`.

    If there is no room for that, the stamps are 1 ns apart from `after_ns` on.

    Args:
        count: Number of stamps; at least 1.
        after_ns: A moment that is before the first of them.
        until_ns: The moment of the last one.
        widest_ns: Maximum distance; by default as far as there is room.
    """
    step_ns = (until_ns - after_ns) // count
    if widest_ns is not None and widest_ns < step_ns:
        step_ns = widest_ns
    step_ns = max(step_ns, 1)
    first_ns = max(until_ns - (count - 1) * step_ns, after_ns + 1)
    return range(first_ns, first_ns + count * step_ns, step_ns)
