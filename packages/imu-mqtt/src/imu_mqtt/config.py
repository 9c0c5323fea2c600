"""The parameters of a broker and a topic, and the settings made from them."""

import errno
import os
import stat
import uuid
from collections.abc import Mapping
from typing import Any
from unicodedata import category
from urllib.parse import SplitResult, urlsplit

from attrs import field, frozen

from rosbase import ParameterError, ParameterSpec, ParameterValue, TransportError

__all__ = ["PARAMETERS", "PASSWORD_VARIABLE", "Address", "MqttConfig"]

PASSWORD_VARIABLE = "ROSBASE_MQTT_PASSWORD"
"""Environment variable that may hold the password."""

_PORTS = {"tcp": 1883, "mqtt": 1883, "mqtts": 8883, "ssl": 8883, "ws": 80, "wss": 443, "unix": 0}
_SECURE = frozenset({"mqtts", "ssl", "wss"})
_WITHOUT_PATH = frozenset(_PORTS) - {"ws", "wss", "unix"}
_MOST_BYTES = 65_535


def _text(name: str, default: str, description: str, *choices: str) -> ParameterSpec:
    return ParameterSpec(name, default, description, choices=choices)


PARAMETERS: tuple[ParameterSpec, ...] = (
    _text(
        "server_address",
        "tcp://localhost:1883",
        "the broker: tcp://, mqtt://, mqtts://, ws:// or wss:// host:port, or unix:///path",
    ),
    _text(
        "mqtt_topic", "esp32/imu", "the topic to read; with + or #, the first that gives a sample"
    ),
    ParameterSpec("qos", 0, "quality of service of the subscription", minimum=0, maximum=2),
    _text("client_id", "", "client id; empty: a generated one, unique"),
    ParameterSpec(
        "keepalive", 15, "seconds of silence after which a ping is sent", minimum=1, maximum=65_535
    ),
    _text("mqtt_version", "3.1.1", "version of the protocol", "3.1.1", "5"),
    _text("username", "", f"user name; the password is in ${PASSWORD_VARIABLE} or a file"),
    _text("password_file", "", "a file that holds the password, and nothing else"),
    _text("tls_ca_file", "", "CA certificates to trust, in PEM; empty: the system's"),
    _text("tls_cert_file", "", "client certificate, in PEM, if the broker requires one"),
    _text("tls_key_file", "", "key of the client certificate, in PEM"),
    _text(
        "status_topic",
        "",
        "topic of the retained status, `online` or `offline` (last will); empty: none",
    ),
    ParameterSpec(
        "wait_for_broker",
        default=False,
        description="wait for a broker that is absent or refuses, instead of failing",
    ),
)
"""Parameters that the transport adds to a reader's. The first one selects the broker."""


@frozen
class Address:
    """Address of a broker."""

    scheme: str
    host: str
    """Name or address; of a Unix socket, its path."""
    port: int
    path: str = "/mqtt"
    """Path of a WebSocket."""

    @property
    def is_secure(self) -> bool:
        """Whether it is reached through TLS."""
        return self.scheme in _SECURE

    def __str__(self) -> str:
        return f"{self.scheme}://{self.host if self.scheme == 'unix' else self.place}"

    @property
    def place(self) -> str:
        """Host and port, as in a URL."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{host}:{self.port}"

    @classmethod
    def parse(cls, text: str) -> "Address":
        """Return the address in a URL.

        Raises:
            ParameterError: It is not a URL, or has more parts than an address.
        """
        # What these errors say may be a part of a password.
        try:
            url = urlsplit(text)
        except ValueError:
            url = urlsplit("")
        try:
            port = url.port
        except ValueError:
            port = 0
        if complaint := _complaint(text, url, port):
            raise ParameterError(f"parameter server_address {complaint}")
        if url.scheme == "unix":
            return cls("unix", url.path, 0)
        return cls(url.scheme, url.hostname or "", port or _PORTS[url.scheme], url.path or "/mqtt")


@frozen
class MqttConfig:
    """Settings of the connection and the subscription."""

    address: Address
    topic: str
    qos: int = 0
    client_id: str = field(factory=lambda: f"rosbase-{uuid.uuid4().hex[:12]}")
    keepalive_s: int = 15
    version: str = "3.1.1"
    username: str = ""
    password_file: str = ""
    ca_file: str = ""
    cert_file: str = ""
    key_file: str = ""
    status_topic: str = ""
    wait_for_broker: bool = False

    @classmethod
    def from_values(cls, values: Mapping[str, ParameterValue]) -> "MqttConfig":
        """Return the settings from checked parameter values.

        Raises:
            ParameterError: They contradict each other, or a topic is invalid.
        """
        given: dict[str, Any] = dict(values)
        address = Address.parse(given["server_address"])
        for name in ("mqtt_topic", "status_topic", "client_id", "username"):
            _check_text(name, given[name])
        _check_topic("mqtt_topic", given["mqtt_topic"], may_be_filter=True)
        if given["status_topic"]:
            _check_topic("status_topic", given["status_topic"], may_be_filter=False)
            if _stands_for(given["mqtt_topic"], given["status_topic"]):
                raise ParameterError("parameter status_topic matches mqtt_topic")
        for name, needed in (("tls_key_file", "tls_cert_file"), ("password_file", "username")):
            if given[name] and not given[needed]:
                raise ParameterError(f"parameter {name} needs {needed}")
        files = [_path(given[name]) for name in ("tls_ca_file", "tls_cert_file", "tls_key_file")]
        if any(files) and not address.is_secure:
            raise ParameterError(f"parameters tls_*: {address} is not a secure address")
        made_up = {"client_id": given["client_id"]} if given["client_id"] else {}
        return cls(
            address,
            given["mqtt_topic"],
            given["qos"],
            keepalive_s=given["keepalive"],
            version=given["mqtt_version"],
            username=given["username"],
            password_file=_path(given["password_file"]),
            ca_file=files[0],
            cert_file=files[1],
            key_file=files[2],
            status_topic=given["status_topic"],
            wait_for_broker=given["wait_for_broker"],
            **made_up,
        )

    @property
    def is_filter(self) -> bool:
        """Whether the topic has a wildcard."""
        return "+" in self.topic or "#" in self.topic

    def read_password(self) -> str | None:
        """Return the password, from the file or the environment, as it is now.

        Raises:
            TransportError: The file cannot be read, or holds no password.
        """
        if not self.password_file:
            password, source = os.environ.get(PASSWORD_VARIABLE), f"${PASSWORD_VARIABLE}"
        else:
            password, source = self._read_password_file(), f"password_file {self.password_file!r}"
        if not _is_text(password or ""):
            raise TransportError(f"{source}: it is not a password in UTF-8")
        if self.password_file and not password:
            raise TransportError(f"{source}: it is empty")
        return password

    def _read_password_file(self) -> str:
        # Bytes that are no text are let through here: the codec's error would quote them.
        how: dict[str, Any] = {"encoding": "utf-8", "errors": "surrogateescape"}
        try:
            with open(self.password_file, opener=_open_file, **how) as file:
                return str(file.read(_MOST_BYTES + 2)).rstrip("\r\n")
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", "") or "it names no file"
            raise TransportError(f"password_file {self.password_file!r}: {reason}") from error


def _complaint(text: str, url: SplitResult, port: int | None) -> str:
    """Return the fault of an address, without its secrets; empty if there is none."""
    known = ", ".join(f"{scheme}://" for scheme in _PORTS)
    if "@" in text and not text.startswith("unix:"):
        return f"must not contain a user or a password: set username and ${PASSWORD_VARIABLE}"
    if url.scheme not in _PORTS:
        return f"must be one of {known}, followed by host:port"
    if not text.isprintable() or " " in text:
        return "must not contain blanks or unprintable characters"
    if "?" in text or "#" in text or (url.path not in ("", "/") and url.scheme in _WITHOUT_PATH):
        return "must end after the port; only ws:// and wss:// have a path"
    if url.scheme == "unix":
        return "" if url.path and not url.netloc else "unix:// takes an absolute path"
    if not url.hostname:
        return "names no host"
    return "takes a port from 1 to 65535" if port == 0 else ""


def _open_file(path: str, flags: int) -> int:
    """Open a file, but no pipe: a pipe can be read once, and each connection needs the password."""
    fd = os.open(path, flags | os.O_NONBLOCK)
    if stat.S_ISFIFO(os.fstat(fd).st_mode):
        os.close(fd)
        raise OSError(errno.EINVAL, "it is a pipe, not a file")
    return fd


def _path(text: str) -> str:
    """Return a path, with the user's home for ~, as shells do. Empty stays empty."""
    return os.path.expanduser(text)


def _stands_for(topic_filter: str, topic: str) -> bool:
    """Return whether a subscription receives messages of a topic."""
    wanted, levels = topic_filter.split("/"), topic.split("/")
    if wanted[-1] == "#":
        wanted.pop()
        levels = levels[: len(wanted)]
    return len(wanted) == len(levels) and all(
        one in ("+", other) for one, other in zip(wanted, levels, strict=True)
    )


def _is_text(text: str) -> bool:
    """Return whether MQTT can carry the text."""
    try:
        return "\0" not in text and len(text.encode()) <= _MOST_BYTES
    except UnicodeEncodeError:
        return False


def _check_text(name: str, text: str) -> None:
    if not _is_text(text):
        raise ParameterError(f"parameter {name} takes at most {_MOST_BYTES} bytes of UTF-8, no NUL")
    # Brokers may hang up on them, without a word.
    if any(category(character) == "Cc" for character in text):
        raise ParameterError(f"parameter {name} takes no control characters, such as line ends")


def _check_topic(name: str, topic: str, *, may_be_filter: bool) -> None:
    if not topic:
        raise ParameterError(f"parameter {name} takes a topic")
    if not may_be_filter and topic.startswith("$"):
        raise ParameterError(
            f"parameter {name} must not start with $: these topics are the broker's own"
        )
    levels = topic.split("/")
    wild = [level for level in levels if "+" in level or "#" in level]
    if wild and not may_be_filter:
        raise ParameterError(f"parameter {name} takes one topic, without + and #")
    if any(level not in ("+", "#") for level in wild) or "#" in levels[:-1]:
        raise ParameterError(f"parameter {name}: + stands for a whole level, # for the last ones")
