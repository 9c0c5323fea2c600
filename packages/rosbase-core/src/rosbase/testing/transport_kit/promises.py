"""What the kit asks of the author before it can check anything."""

from rosbase.testing.promise import Promise

__all__ = ["CALLS", "FACTORY", "PAGE", "PEER", "PEER_ABILITIES", "PREPARATIONS"]

PAGE = "plugins/transport-contract"

PEER = Promise(
    "a-peer-plays-the-device",
    "make_peer gives what plays the device: parameters, send and close.",
    PAGE,
)
PEER_ABILITIES = Promise(
    "the-peer-can-do-what-is-declared",
    "The peer has what the capabilities of the contract need.",
    PAGE,
)
FACTORY = Promise(
    "a-transport-is-made",
    "make_transport gives a rosbase.Transport.",
    PAGE,
)
CALLS = Promise(
    "every-call-is-written",
    "open, start, stop, close, is_open and health do their work and give what they should.",
    PAGE,
)

PREPARATIONS = (PEER, PEER_ABILITIES, FACTORY, CALLS)
"""Broken by whichever check is first to come upon it."""
