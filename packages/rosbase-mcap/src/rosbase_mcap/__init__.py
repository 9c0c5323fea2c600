"""Recordings of rosbase: MCAP files of programs, and tests that replay them."""

from typing import TYPE_CHECKING

from rosbase.messages.lazy import names_of, on_demand

if TYPE_CHECKING:
    from rosbase_mcap.replaying.in_process import Replay, replay
else:
    # A plugin that is only listed imports nothing.
    __getattr__ = on_demand(
        __name__,
        {"Replay": "replaying.in_process", "replay": "replaying.in_process"},
        __name__,
    )

__all__ = ["Replay", "replay"]

__dir__ = names_of(__all__)
