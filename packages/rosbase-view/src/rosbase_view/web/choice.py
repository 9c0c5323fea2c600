"""One of several topics or nodes, as a drop-down shows it. Pure."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

from rosbase_view.owners import owners

__all__ = ["Choice", "Key"]

Key: TypeAlias = tuple[str, int]
"""Name of a topic or a node, and a pid."""


class Choice:
    """Options, and the chosen one.

    The choice stays while its topic or node is away. If the name comes back with another pid, from
    a program that was started again, it is chosen.
    """

    def __init__(self) -> None:
        """Begin without options."""
        self._keys: list[Key] = []
        self._owners: Mapping[Key, str] = {}
        self._chosen: Key | None = None

    def offer(self, keys: Iterable[Key], programs: Mapping[int, str]) -> None:
        """Take the options that there are now. Choose the first if none was chosen before.

        Args:
            keys: The options.
            programs: Name of the program of each pid.
        """
        self._keys = sorted(keys)
        self._owners = owners(self._keys, programs)
        if self._chosen in self._keys:
            return
        name = self._chosen[0] if self._chosen is not None else None
        back = [key for key in self._keys if name in (None, key[0])]
        if back:
            self._chosen = back[0]

    def choose(self, label: str) -> None:
        """Take a label that the user has chosen; one that is not offered is ignored."""
        for key in self._keys:
            if self._label(key) == label:
                self._chosen = key

    def prefer(self, key: Key) -> None:
        """Choose a key, if it is there."""
        if key in self._keys:
            self._chosen = key

    @property
    def key(self) -> Key | None:
        """Chosen option; None if it is away, or if there was never any."""
        return self._chosen if self._chosen in self._keys else None

    @property
    def labels(self) -> Sequence[str]:
        """Labels of all options, always with the chosen one."""
        labels = [self._label(key) for key in self._keys]
        return labels if self._chosen is None or self.key else [self.label, *labels]

    @property
    def label(self) -> str:
        """Label of the chosen option; empty if there was never any."""
        if self._chosen is None:
            return ""
        return self._label(self._chosen) if self.key else f"{self._chosen[0]} (gone)"

    def _label(self, key: Key) -> str:
        """Return the name, and its program too if others have the same name."""
        owner = self._owners.get(key)
        return key[0] if owner is None else f"{key[0]} ({owner})"
