"""viser's server behind a token, with real clients of HTTP and WebSocket."""

import gzip
import http.client
import secrets
import socket
from collections.abc import Iterator

import pytest
import viser
import zstandard
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from rosbase import ConfigurationError
from rosbase_view.web import guard
from rosbase_view.web.server import GuardedServer, bind
from support.stopwatch import Stopwatch

TOKEN = "secret-secret-16"
PROTOCOL = Subprotocol(f"viser-v{viser.__version__}")


@pytest.fixture
def port() -> Iterator[int]:
    listening = bind("127.0.0.1", 0)
    port: int = listening.getsockname()[1]
    server = GuardedServer(listening, TOKEN, "robot")
    yield port
    server.stop()


def get(port: int, path: str) -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    try:
        connection.request("GET", path)
        response = connection.getresponse()
        response.read()
        return response
    finally:
        connection.close()


def test_the_page_is_served_to_those_who_know_the_token(port: int) -> None:
    response = get(port, f"/{TOKEN}/")
    assert response.status == 200
    assert response.headers["Content-Type"].startswith("text/html")
    # Its address is a secret.
    assert response.headers["Referrer-Policy"] == "no-referrer"


@pytest.mark.parametrize("encoding", ["identity", "gzip"])
def test_the_page_has_the_script_that_watches_the_view(port: int, encoding: str) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    try:
        connection.request("GET", f"/{TOKEN}/", headers={"Accept-Encoding": encoding})
        response = connection.getresponse()
        body = response.read()
        assert len(body) == int(response.headers["Content-Length"])
        page = gzip.decompress(body) if encoding == "gzip" else body
        assert b"No connection to rosbase view" in page.partition(b"</head>")[0]
    finally:
        connection.close()


def test_each_start_has_another_word_for_the_page() -> None:
    words = set()
    for _ in range(2):
        listening = bind("127.0.0.1", 0)
        port = listening.getsockname()[1]
        server = GuardedServer(listening, TOKEN, "robot")
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
        try:
            connection.request("GET", f"/{TOKEN}/alive")
            words.add(connection.getresponse().read())
        finally:
            connection.close()
            server.stop()
    assert len(words) == 2


@pytest.mark.parametrize("path", ["/", "/index.html", "/alive", "/secret-secret-17/"])
def test_the_page_is_refused_without_the_token(port: int, path: str) -> None:
    assert get(port, path).status == 403


def test_messages_are_sent_to_those_who_know_the_token(port: int) -> None:
    url = f"ws://127.0.0.1:{port}/{TOKEN}"
    with connect(url, subprotocols=[PROTOCOL], proxy=None) as connection:
        assert isinstance(connection.recv(timeout=10), bytes)


@pytest.mark.parametrize("path", ["", "/", "/secret-secret-17", f"/?token={TOKEN}"])
@pytest.mark.parametrize("origin", [None, "http://127.0.0.1:{port}", "http://evil.example"])
def test_a_connection_without_the_token_is_refused(
    port: int, path: str, origin: str | None
) -> None:
    headers = {} if origin is None else {"Origin": origin.format(port=port)}
    with (
        pytest.raises(InvalidStatus) as refused,
        connect(
            f"ws://127.0.0.1:{port}{path}",
            subprotocols=[PROTOCOL],
            additional_headers=headers,
            proxy=None,
        ),
    ):
        pass
    assert refused.value.response.status_code == 403


def test_a_client_that_never_reads_delays_neither_others_nor_the_end() -> None:
    listening = bind("127.0.0.1", 0)
    url = f"ws://127.0.0.1:{listening.getsockname()[1]}/{TOKEN}"
    server = GuardedServer(listening, TOKEN, "robot")
    filling, mark = server.gui.add_html(""), server.gui.add_html("")
    # It reads ahead by one message.
    idle = connect(url, subprotocols=[PROTOCOL], proxy=None, max_queue=1, max_size=None)
    with connect(url, subprotocols=[PROTOCOL], proxy=None, max_size=None) as reader:
        for number in range(10):
            # Together more than the kernel keeps for the other one.
            filling.content = secrets.token_hex(1_000_000)
            mark.content = f"update {number}."
            while mark.content.encode() not in opened(reader.recv(timeout=10)):
                pass
    with Stopwatch() as stopwatch:
        server.stop()
        assert stopwatch.took_s < 4.0
    idle.socket.close()
    idle.close()


def opened(frame: bytes | str) -> bytes:
    """The messages of a frame of viser's: two sizes, and the rest compressed."""
    assert isinstance(frame, bytes)
    size = int.from_bytes(frame[8:16], "little")
    return zstandard.ZstdDecompressor().decompress(frame[16 : 16 + size])


def test_a_request_that_is_none_does_not_reach_the_terminal(
    port: int, capfd: pytest.CaptureFixture[str]
) -> None:
    with socket.create_connection(("127.0.0.1", port), timeout=10) as connection:
        connection.sendall(b"\x16\x03\x01 this is no HTTP\r\n\r\n")
        while connection.recv(4096):
            pass
    # The server has taken it, and takes more.
    assert get(port, "/").status == 403
    assert capfd.readouterr() == ("", "")


def test_a_port_in_use_is_one_line_and_no_other_port() -> None:
    with bind("127.0.0.1", 0) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(
            ConfigurationError,
            match=f"^cannot listen on 127.0.0.1 port {port}: Address already in use$",
        ):
            bind("127.0.0.1", port)


def test_an_address_of_another_machine_is_one_line() -> None:
    with pytest.raises(
        ConfigurationError, match=r"^cannot listen on 192.0.2.1 port 0: [A-Z][^(]*$"
    ):
        bind("192.0.2.1", 0)


def test_a_scene_is_never_shared_with_a_server_of_others(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise AssertionError("a tunnel was opened")

    monkeypatch.setattr("viser._viser.ViserTunnel", fail)
    server = GuardedServer(bind("127.0.0.1", 0), TOKEN, "robot")
    try:
        # What the message of a browser calls.
        assert server.request_share_url() is None
    finally:
        server.stop()


def test_a_viser_that_makes_its_listener_in_another_way_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Other:
        """A module that viser does not use."""

        serve = staticmethod(print)

    monkeypatch.setattr(guard, "listener", Other)
    with (
        bind("127.0.0.1", 0) as listening,
        pytest.raises(ConfigurationError, match="is not supported"),
    ):
        GuardedServer(listening, TOKEN, "robot")


def test_nothing_is_printed(capfd: pytest.CaptureFixture[str]) -> None:
    GuardedServer(bind("127.0.0.1", 0), TOKEN, "robot").stop()
    assert capfd.readouterr() == ("", "")
