"""Results and errors of calls as JSON, so that a replay returns or raises the same."""

import builtins

from rosbase import errors
from rosbase.entries.payloads import Json

__all__ = ["RecordedError", "error_from_json", "error_to_json"]


class RecordedError(RuntimeError):
    """An error of a recording whose class is not one of rosbase or Python."""


def error_to_json(error: BaseException) -> Json:
    """Return the class and the text of an error, and whether another try may help, if it says so.

    Args:
        error: An error of a transport, or of a call.
    """
    bases = [base.__name__ for base in type(error).__mro__]
    name = next((base for base in bases if _class_of(base) in type(error).__mro__), "Exception")
    return {
        "class": name,
        "text": str(error),
        "retryable": getattr(error, "retryable", None),
    }


def error_from_json(value: Json) -> BaseException:
    """Return an error that equals the recorded one, as far as it is known.

    An error of a class that only a plugin has comes back as its nearest base in rosbase or Python.
    """
    facts = value if isinstance(value, dict) else {}
    text = str(facts.get("text", ""))
    kind = _class_of(str(facts.get("class", ""))) or RecordedError
    try:
        # Without the constructor, which may make its text of other arguments.
        error = kind.__new__(kind, text)
        error.args = (text,)
    except TypeError:
        error = RecordedError(text)
    if str(error) != text:
        error = RecordedError(text)
    if isinstance(facts.get("retryable"), bool):
        error.retryable = facts["retryable"]  # type: ignore[attr-defined]  # of TransportError
    return error


def _class_of(name: str) -> type[BaseException] | None:
    found = getattr(errors, name, None) or getattr(builtins, name, None)
    return found if isinstance(found, type) and issubclass(found, BaseException) else None
