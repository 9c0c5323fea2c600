"""Preparations of the author that the kit needs before it can check anything."""

from rosbase.testing.promise import Promise

__all__ = ["CALLS", "FACTORY", "PAGE", "PEER", "PEER_ABILITIES", "PREPARATIONS"]

PAGE = "plugins/transport-contract"

PEER = Promise(
    "a-peer-plays-the-device",
    "make_peer returns a simulated device with parameters, send and close.",
    PAGE,
)
PEER_ABILITIES = Promise(
    "the-peer-can-do-what-is-declared",
    "The peer has the methods that the capabilities of the contract need.",
    PAGE,
)
FACTORY = Promise(
    "a-transport-is-made",
    "make_transport returns a rosbase.Transport.",
    PAGE,
)
CALLS = Promise(
    "every-call-is-written",
    "open, start, stop, close, is_open and health are implemented and return valid values.",
    PAGE,
)

PREPARATIONS = (PEER, PEER_ABILITIES, FACTORY, CALLS)
"""Promises about the author's preparations. Any check may break them."""
