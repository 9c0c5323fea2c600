"""Answers to the requests of clients, one module per subject; imported at the first request.

A subject's module exports `ANSWERS: dict[str, Answerer]`, from the name of a request to the
function that answers it: `answer(session, request) -> Reply`. It is called on the thread of the
control socket, also while the main loop blocks, so it must return within a millisecond or so, wait
for nothing, and not run code of the program. It answers in one of these ways:

- now: it returns the dict that becomes `ok`.
- now, with bytes: it returns `(ok, data)`; `data` is bytes or another buffer of bytes.
- later: it keeps the request, and returns `request.wait(give_up)`. Any thread then calls
  `request.answer(ok, data)` or `request.fail(error)` once. If nobody does so in time (the
  argument `timeout_ns`, 5 s by default), the request fails, after `give_up` was called.
- on the main loop, for whatever changes something: it returns `on_loop(request, program, change)`;
  `change()` is called between ticks, and returns the dict.
- with a stream: it returns a `Stream`, whose `ok` and `data` are the answer. Its events follow as
  fast as the client reads them.
- with an error: it raises `ControlError(text, kind, suggestions)`. Any other exception is logged,
  and becomes an error of kind `failed`.

`request.text("topic")`, `whole`, `flag` and `texts` read arguments and check their types;
`request.data` are the bytes behind the request. `session.kept` holds things for later requests of
the same connection, and `session.on_close(function)` releases them. `session.call(function)` brings
a function from any thread to the thread of the socket.
"""

from importlib import import_module

from rosbase.control.requests import Answerer

__all__ = ["SUBJECTS", "all_answers"]

SUBJECTS = (
    "processes",
    "nodes",
    "parameters",
    "lifecycle",
    "log",
    "statistics",
    "topics",
    "services",
    "recording",
)
"""Modules of this package."""


def all_answers() -> dict[str, Answerer]:
    """Return all answers by the names of the requests."""
    known: dict[str, Answerer] = {}
    for subject in SUBJECTS:
        known |= import_module(f"{__name__}.{subject}").ANSWERS
    return known
