"""Take the fields of a mapping one by one, and note what is wrong with them."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rosbase.errors import ConfigurationError
from rosbase.launcher.description.outside import at_home, objection_to
from rosbase.launcher.description.tree import Faults, Value
from rosbase.parameters.checking import did_you_mean
from rosbase.text.printable import printable

__all__ = ["Fields"]


class Fields:
    """The fields of one mapping. A missing or wrong field is noted, and gets its default."""

    def __init__(self, value: Value, what: str, known: Sequence[str], faults: Faults) -> None:
        """Note the keys that nobody knows.

        Args:
            value: The mapping; something else is noted.
            what: Name for it in messages.
            known: Keys that it may have.
            faults: Where mistakes are noted.
        """
        self.line = value.line
        self._what = what
        self._faults = faults
        self._values: dict[str, Value] = {}
        if not isinstance(value.data, dict):
            faults.add(value.line, f"{what} is a mapping, not {value.kind}")
            return
        self._values = value.data
        for key, found in self._values.items():
            if key not in known:
                hint = did_you_mean(key, known) or f"; it has {', '.join(known)}"
                faults.add(found.line, f"{what} has no '{printable(key)}'{hint}")

    def __contains__(self, key: str) -> bool:
        """Return whether the field is there and not empty."""
        found = self._values.get(key)
        return found is not None and found.data is not None

    def value(self, key: str) -> Value | None:
        """Return the field; None if it is missing or empty."""
        return self._values[key] if key in self else None

    def line_of(self, key: str) -> int:
        """Return the line of a field, or else the line of the mapping."""
        return self._values[key].line if key in self._values else self.line

    def lines(self) -> dict[str, int]:
        """Return the line of each field. The empty name has the line of the mapping."""
        return {"": self.line, **{key: value.line for key, value in self._values.items()}}

    def fault(self, key: str, text: str) -> None:
        """Note a mistake in a field."""
        self._faults.add(self.line_of(key), text)

    def text(self, key: str, default: str = "", *, is_required: bool = False) -> str:
        """Return a text; a number, or `true`, counts as the text that it is written as."""
        value = self.value(key)
        if value is None:
            if is_required:
                self.fault(key, f"{self._what} has no {key}")
            return default
        if not value.is_scalar:
            self._wrong_kind(key, "a text")
            return default
        if objection := objection_to(value.text):
            self.fault(key, f"{key} {objection}")
            return default
        return value.text

    def path(self, key: str, folder: Path, default: str = ".") -> Path:
        """Return a path, which is relative to the folder or begins with `~`."""
        return folder / self.at_home(key, self.text(key, default))

    def at_home(self, key: str, text: str) -> Path:
        """Return the path that a text of the field means, after noting an unknown home."""
        try:
            return at_home(text)
        except ConfigurationError as error:
            self.fault(key, f"{key}: {error}")
            return Path(text)

    def flag(self, key: str, *, default: bool) -> bool:
        """Return true or false."""
        value = self.value(key)
        if value is None or isinstance(value.data, bool):
            return default if value is None else value.data
        self._wrong_kind(key, "true or false")
        return default

    def number(self, key: str, default: Any, *, is_whole: bool = False) -> Any:
        """Return a number that is not negative."""
        value = self.value(key)
        if value is None:
            return default
        kinds = (int,) if is_whole else (int, float)
        number = value.data
        if not isinstance(number, kinds) or isinstance(number, bool) or not 0 <= number < 1e9:
            self._wrong_kind(key, "a whole number from 0 on" if is_whole else "a number from 0 on")
            return default
        return number

    def items(self, key: str, what: str) -> list[Value]:
        """Return the items of a list; `what` names its kind in a message."""
        value = self.value(key)
        if value is None:
            return []
        if not isinstance(value.data, list):
            self._wrong_kind(key, what)
            return []
        return value.data

    def texts_by_name(self, key: str, what: str) -> dict[str, str]:
        """Return a mapping of names to scalars, as they are written."""
        return dict(self._scalars(key, what))

    def _scalars(self, key: str, what: str) -> Iterator[tuple[str, str]]:
        value = self.value(key)
        if value is None:
            return
        if not isinstance(value.data, dict):
            self._wrong_kind(key, what)
            return
        for name, item in value.data.items():
            if objection := objection_to(item.text):
                self._faults.add(item.line, f"{key}: '{printable(name)}' {objection}")
            elif item.is_scalar:
                yield name, item.text
            elif item.data is None:
                # Not as it is written, which may be `~` or `null`.
                yield name, ""
            else:
                self._faults.add(
                    item.line, f"{key}: '{printable(name)}' is a text, not {item.kind}"
                )

    def _wrong_kind(self, key: str, wanted: str) -> None:
        kind = self._values[key].kind
        shown = self._values[key].text
        found = f"{kind}: {printable(shown, 40)!r}" if shown else kind
        self.fault(key, f"{key} is {wanted}, not {found}")
