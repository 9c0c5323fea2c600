"""Which programs hear each other. Pure.

The backend `local` joins the nodes of one program and its child processes; `ros2` joins all that
are in the same domain.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rosbase.control.shapes import Endpoint, Process, Topic

__all__ = ["Bus", "buses", "observers", "on_several", "with_children"]


class Bus:
    """Processes that share their topics."""

    __slots__ = ("backend", "network", "pids")

    def __init__(self, backend: str, network: str, pids: Iterable[int]) -> None:
        self.backend = backend
        self.network = network
        """Name of the network at the backend, for `ros2` the domain; empty if it has none."""
        self.pids = frozenset(pids)


def buses(processes: Iterable[Process]) -> list[Bus]:
    """Return the groups of processes that hear each other."""
    known = {process["pid"]: process for process in processes}
    parent = {
        child["pid"]: pid
        for pid, process in known.items()
        for program in process["programs"]
        # The programs of a launcher are programs of their own.
        if program["kind"] != "launcher"
        for child in program["children"]
        if child["pid"] in known
    }
    groups: dict[tuple[str, str, int], set[int]] = {}
    for pid, process in known.items():
        joined = [program for program in process["programs"] if program["backend"]]
        backend = joined[0]["backend"] if joined else "local"
        # Programs of an earlier version do not tell it.
        network = joined[0].get("network", "") if joined else ""
        root = _root(pid, parent) if backend == "local" else 0
        groups.setdefault((backend, network, root), set()).add(pid)
    return [Bus(backend, network, pids) for (backend, network, _), pids in sorted(groups.items())]


def with_children(process: Process, processes: Iterable[Process]) -> list[Process]:
    """Return a process and those among the others that descend from it, also by a launcher."""
    known = {one["pid"]: one for one in processes}
    # Pids are told by other processes, which may be wrong: none is taken twice.
    found = {process["pid"]: process}
    waiting = [process]
    while waiting:
        for program in waiting.pop()["programs"]:
            for child in program["children"]:
                pid = child["pid"]
                if pid in known and pid not in found:
                    found[pid] = known[pid]
                    waiting.append(known[pid])
    return list(found.values())


def _root(pid: int, parent: Mapping[int, int]) -> int:
    """Return the process from which all parents descend."""
    seen = {pid}
    # Pids are told by other processes, which may be wrong.
    while (above := parent.get(pid)) is not None and above not in seen:
        seen.add(above)
        pid = above
    return pid


def on_several(topic: Topic, all_buses: Iterable[Bus]) -> list[Bus]:
    """Return the buses that carry the topic."""
    ends = {end["pid"] for end in [*topic["publishers"], *topic["subscriptions"]]}
    return [bus for bus in all_buses if bus.pids & ends]


def observers(topic: Topic, bus: Bus) -> list[int]:
    """Return the processes in which every message of the topic is seen exactly once.

    A process sees what it publishes itself, and what its subscriptions get from others.
    """
    publishers = _pids(topic["publishers"], bus)
    subscribers = _pids(topic["subscriptions"], bus)
    if len(publishers) > 1 and subscribers:
        return [min(publishers & subscribers or subscribers)]
    return sorted(publishers) or sorted(subscribers)[:1]


def _pids(ends: Iterable[Endpoint], bus: Bus) -> set[int]:
    return {end["pid"] for end in ends if end["pid"] in bus.pids}
