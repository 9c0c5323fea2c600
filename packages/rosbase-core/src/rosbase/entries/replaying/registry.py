"""The objects that entries name by a number."""

from collections import Counter
from typing import TypeAlias

from rosbase.entries.conductor import Play
from rosbase.entries.kinds import Numbered
from rosbase.entries.script import Creation

__all__ = ["Registry"]

_Key: TypeAlias = tuple[int, str, int]
"""Class, text, and how many of both were created before: what changed code keeps."""


class Registry:
    """Knows the objects of the program and of the recording, which may differ.

    While both create the same, numbers agree. After a difference, a number of the recording means
    the object with the same class and text, the first or the second or so on.
    """

    def __init__(self) -> None:
        self._live = _Side()
        self._recorded = _Side()
        self._plays: dict[_Key, Play] = {}

    def create(self, what: Numbered, text: str, play: Play) -> int:
        """Enter an object of the program, and return its number."""
        number, key = self._live.add(what, text)
        self._plays[key] = play
        return number

    def note_recorded(self, creation: Creation) -> None:
        """Note an object of the recording."""
        self._recorded.add(creation.what, creation.text)

    def forget(self, what: Numbered, number: int) -> None:
        """Drop an object of the program that no entry names any more."""
        key = self._live.keys.pop((what, number), None)
        if key is not None:
            self._plays.pop(key, None)
            recorded = self._recorded.keys
            # Usually they agree.
            if recorded.get((what, number)) == key:
                del recorded[what, number]

    def play_of(self, what: Numbered, number: int) -> Play | None:
        """Return what to do with an entry for an object of the recording, if the program has it."""
        key = self._recorded.keys.get((what, number))
        return None if key is None else self._plays.get(key)

    def recorded_text(self, what: Numbered, number: int) -> str:
        """Return the text of an object of the recording; empty if it is not known any more."""
        key = self._recorded.keys.get((what, number))
        return "" if key is None else key[1]


class _Side:
    """The objects of one run, by number."""

    def __init__(self) -> None:
        self.keys: dict[tuple[int, int], _Key] = {}
        self._numbers: Counter[int] = Counter()
        self._same: Counter[tuple[int, str]] = Counter()

    def add(self, what: int, text: str) -> tuple[int, _Key]:
        number, same = self._numbers[what], self._same[what, text]
        self._numbers[what] += 1
        self._same[what, text] += 1
        key = self.keys[what, number] = (what, text, same)
        return number, key
