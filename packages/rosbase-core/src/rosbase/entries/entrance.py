"""Where messages and requests of other threads come into a program that is recorded."""

import copy
from collections.abc import Callable
from typing import Any, Protocol, cast

from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import NUMBERED, Kind
from rosbase.entries.script import Entry
from rosbase.entries.turn import Turn

__all__ = ["Entrance", "Form", "Remaker"]


class Form(Protocol):
    """The way from a message to bytes, and back."""

    @property
    def encode(self) -> Callable[[Any], bytes]:
        """Return the bytes of a message. TypeError or ValueError names a field that has none."""
        ...

    @property
    def decode(self) -> Callable[[bytes], Any]:
        """Return the message of some bytes."""
        ...


class Remaker:
    """Makes what comes in anew of its bytes.

    So the program gets the same as in a replay, also where the bytes have less than the message,
    such as a float32.
    """

    __slots__ = ("_conductor", "_find_form", "_form", "_text")

    def __init__(self, conductor: Conductor, text: str, find_form: Callable[[], Form]) -> None:
        """Prepare for one topic or service.

        Args:
            conductor: The conductor.
            text: The topic or the service.
            find_form: Returns the form of what comes in. TypeError if it has no schema.
        """
        self._conductor = conductor
        self._text = text
        # Most ends get nothing from outside, and need no form.
        self._find_form = find_form
        self._form: Form | None = None

    def remake(self, message: Any) -> tuple[bytes, Any]:
        """Return the bytes of a message, and the message that a replay makes of them.

        Without a schema, the bytes are empty, and the recording is spoiled.
        """
        try:
            data = self._found().encode(message)
            return data, self._found().decode(data)
        except (TypeError, ValueError) as error:
            self._conductor.spoil(f"{self._text}: {error}")
            # Its owner may change it before it has come in.
            return b"", copy.deepcopy(message)

    def make(self, data: bytes) -> Any:
        """Return the message of some bytes.

        Raises:
            TypeError: Such messages have no schema.
            WireError: The bytes are no such message.
        """
        return self._found().decode(data)

    def _found(self) -> Form:
        if self._form is None:
            self._form = self._find_form()
        return self._form


class Entrance:
    """The way into the program through one publisher, subscription or service."""

    __slots__ = ("_conductor", "_kind", "_number", "_play", "_remaker")

    def __init__(
        self,
        conductor: Conductor,
        kind: Kind,
        text: str,
        find_form: Callable[[], Form],
        play: Callable[[Any], object],
    ) -> None:
        """Number the end that has it.

        Args:
            conductor: The conductor.
            kind: What comes in: a kind of `NUMBERED`.
            text: The topic or the service.
            find_form: As for `Remaker`.
            play: Takes a message in a replay.
        """
        self._conductor = conductor
        self._kind = kind
        self._play = play
        self._remaker = Remaker(conductor, text, find_form)
        self._number = conductor.number(NUMBERED[kind], text, self._replay)

    @property
    def turn(self) -> Turn:
        """The turn: on the thread that holds it, nothing has to come in."""
        return self._conductor.turn

    @property
    def is_inside(self) -> bool:
        """Whether the calling thread runs the program, so that nothing has to come in."""
        return self._conductor.is_inside

    def ask(self, read: Callable[[], int]) -> int:
        """Return what a function reads about things outside; in a replay, what it has read."""
        return cast("int", self._conductor.fact(read))

    def let_in(self, message: Any, take: Callable[[Any], object]) -> None:
        """Have a message of another thread come in, as an entry.

        Args:
            message: The message.
            take: Takes it on the thread that has the turn.
        """
        data, remade = self._remaker.remake(message)
        self._conductor.come_in(self._kind, (self._number,), data, lambda: take(remade))

    def _replay(self, entry: Entry) -> object:
        return self._play(self._remaker.make(entry.payload))
