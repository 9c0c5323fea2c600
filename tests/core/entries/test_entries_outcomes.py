"""Errors and facts as they are in a recording."""

import math

import pytest

from rosbase.entries.outcomes import RecordedError, error_from_json, error_to_json
from rosbase.entries.payloads import Json, from_json, to_json
from rosbase.errors import DeviceBusyError, ServiceFailedError, TransportError


class PluginError(DeviceBusyError):
    retryable = False


class UnknownError(Exception):
    def __str__(self) -> str:
        return "always this"


def back(error: BaseException) -> BaseException:
    return error_from_json(from_json(to_json(error_to_json(error))))


@pytest.mark.parametrize(
    ("error", "kind"),
    [
        (TransportError("gone"), TransportError),
        (DeviceBusyError("held"), DeviceBusyError),
        (ServiceFailedError("/add", "no"), ServiceFailedError),
        (OSError(5, "Input/output error"), OSError),
        (PluginError("held by us"), DeviceBusyError),
        (KeyError("fps"), RecordedError),
        (UnicodeDecodeError("utf-8", b"x", 0, 1, "bad"), RecordedError),
        (UnknownError(), Exception),
    ],
    ids=lambda value: getattr(value, "__name__", type(value).__name__),
)
def test_an_error_comes_back_with_its_class_and_text(
    error: BaseException, kind: type[BaseException]
) -> None:
    again = back(error)
    assert type(again) is kind
    assert str(again) == str(error)


def test_it_says_again_whether_another_try_may_help() -> None:
    assert back(PluginError("x")).retryable is False  # type: ignore[attr-defined]  # of these classes
    assert back(TransportError("x")).retryable is True  # type: ignore[attr-defined]  # of these classes


def test_floats_and_texts_come_back_equal() -> None:
    value: Json = {"a": [0.1, 1e300, -0.0, math.inf], "text": "\udc80 \u00fc"}
    assert from_json(to_json(value)) == value
    assert math.isnan(from_json(to_json(math.nan)))  # type: ignore[arg-type]  # a float
