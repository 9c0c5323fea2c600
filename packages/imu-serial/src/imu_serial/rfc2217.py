"""The client's side of RFC 2217: a serial port over telnet. Pure: bytes in, data and replies out.

pyserial has a client, too. But that has its own thread, its `close` takes up to seven seconds, and
no `poll` can wait for its input.
"""

import struct
from collections.abc import Iterator

from imu_serial.config import LEAVE, ON

__all__ = ["Rfc2217Client"]

_IAC, _DONT, _DO, _WONT, _WILL, _SB, _SE = 255, 254, 253, 252, 251, 250, 240
_BINARY, _SUPPRESS_GO_AHEAD, _COM_PORT = 0, 3, 44
_ACCEPTED = (_BINARY, _SUPPRESS_GO_AHEAD, _COM_PORT)

# The client's commands; the server answers with the same and 100 more.
_SET_BAUDRATE, _SET_DATASIZE, _SET_PARITY, _SET_STOPSIZE, _SET_CONTROL = range(1, 6)
_SET_LINESTATE_MASK, _SET_MODEMSTATE_MASK, _PURGE_DATA = 10, 11, 12
_NOTIFY_LINESTATE = 106
_ANSWER = 100

_EIGHT_BITS, _NO_PARITY, _ONE_STOP_BIT, _NO_FLOW_CONTROL, _RECEIVED = 8, 1, 1, 1, 1
_CONTROLS = {"dtr": (8, 9), "rts": (11, 12)}
"""Values that set and clear each line, by parameter."""
_LINESTATES = {0x02: "overrun", 0x04: "parity_error", 0x08: "framing_error", 0x10: "line_break"}

# The longest command that there is has 11 bytes.
_MOST_HELD_BYTES = 256


class Rfc2217Client:
    """Asks a server to set its port, and separates the data of the port from the rest."""

    def __init__(self, baudrate: int, dtr: str = LEAVE, rts: str = LEAVE) -> None:
        """Prepare the greeting: `take_replies` returns it."""
        self._baudrate = baudrate
        self._lines = {"dtr": dtr, "rts": rts}
        self._held = b""
        self._said: set[tuple[int, int]] = set()
        self._is_asked = False
        self._controls: set[int] = set()
        self._replies = bytearray()
        self.rate: int | None = None
        """Rate of the port, once the server has reported it: the settings are done then."""
        self.refusal = ""
        """Reason why there is no port behind this address; empty if there may be."""
        self.errors: dict[str, int] = {}
        """Errors on the line that the server has reported, by reason; the caller empties it."""
        self._say(_WILL, _COM_PORT)
        for option in (_BINARY, _SUPPRESS_GO_AHEAD):
            self._say(_WILL, option)
            self._say(_DO, option)

    def take_replies(self) -> bytes:
        """Return the bytes to send to the server, once."""
        replies, self._replies = bytes(self._replies), bytearray()
        return replies

    @property
    def unconfirmed(self) -> list[str]:
        """Lines whose setting the server has not confirmed."""
        return [name for name, code in self._wanted_controls() if code not in self._controls]

    def feed(self, received: bytes) -> bytes:
        """Take data of the server; return the data of the port in it."""
        if self._held:
            received, self._held = self._held + received, b""
        elif _IAC not in received:
            return received
        data, position = bytearray(), 0
        while (at := received.find(_IAC, position)) >= 0:
            data += received[position:at]
            position = self._command(received, at, data)
            if position < 0:
                self._hold(received[at:])
                return bytes(data)
        data += received[position:]
        return bytes(data)

    def _hold(self, begun: bytes) -> None:
        """Keep a command that is not complete yet."""
        if len(begun) > _MOST_HELD_BYTES:
            self.refusal = "it sends something that is not telnet"
        else:
            self._held = begun

    def _command(self, received: bytes, at: int, data: bytearray) -> int:
        """Take the command that begins there; return where it ends, or -1 if it is not complete."""
        if len(received) < at + 2:
            return -1
        code = received[at + 1]
        if code == _IAC:
            data.append(_IAC)
        elif _WILL <= code <= _DONT:
            if len(received) < at + 3:
                return -1
            self._negotiate(code, received[at + 2])
            return at + 3
        elif code == _SB:
            return self._subnegotiation(received, at + 2)
        return at + 2

    def _subnegotiation(self, received: bytes, at: int) -> int:
        content = bytearray()
        while (end := received.find(_IAC, at)) >= 0 and end + 1 < len(received):
            content += received[at:end]
            at = end + 2
            if received[end + 1] == _SE:
                self._take(bytes(content))
                return at
            content.append(received[end + 1])
        return -1

    def _negotiate(self, code: int, option: int) -> None:
        if (code, option) == (_DONT, _COM_PORT):
            self.refusal = "it does not speak RFC 2217; for bytes as they are write socket://"
        elif code in (_DO, _WILL):
            yes, no = (_WILL, _WONT) if code == _DO else (_DO, _DONT)
            self._say(yes if option in _ACCEPTED else no, option)
            if option == _COM_PORT and not self._is_asked:
                self._is_asked = True
                self._ask_for_settings()

    def _say(self, code: int, option: int) -> None:
        # Once each, so that two that do not agree do not go on for ever.
        if (code, option) not in self._said:
            self._said.add((code, option))
            self._replies += bytes((_IAC, code, option))

    def _ask_for_settings(self) -> None:
        for command, value in (
            (_SET_DATASIZE, _EIGHT_BITS),
            (_SET_PARITY, _NO_PARITY),
            (_SET_STOPSIZE, _ONE_STOP_BIT),
            (_SET_CONTROL, _NO_FLOW_CONTROL),
            *((_SET_CONTROL, code) for _, code in self._wanted_controls()),
            (_SET_MODEMSTATE_MASK, 0),
            (_SET_LINESTATE_MASK, sum(_LINESTATES)),
            (_PURGE_DATA, _RECEIVED),
        ):
            self._order(command, bytes((value,)))
        # Last: when this is answered, the others have been.
        self._order(_SET_BAUDRATE, struct.pack(">I", self._baudrate))

    def _wanted_controls(self) -> Iterator[tuple[str, int]]:
        for name, wish in self._lines.items():
            if wish != LEAVE:
                yield name, _CONTROLS[name][0 if wish == ON else 1]

    def _order(self, command: int, value: bytes) -> None:
        escaped = value.replace(b"\xff", b"\xff\xff")
        self._replies += bytes((_IAC, _SB, _COM_PORT, command)) + escaped + bytes((_IAC, _SE))

    def _take(self, content: bytes) -> None:
        """Take a message of the server in a subnegotiation."""
        if len(content) < 3 or content[0] != _COM_PORT:
            return
        command, value = content[1], content[2:]
        if command == _SET_BAUDRATE + _ANSWER and len(value) == 4:
            (self.rate,) = struct.unpack(">I", value)
        elif command == _SET_CONTROL + _ANSWER:
            self._controls.add(value[0])
        elif command == _NOTIFY_LINESTATE:
            for bit, reason in _LINESTATES.items():
                if value[0] & bit:
                    self.errors[reason] = self.errors.get(reason, 0) + 1
