"""The server of foxglove-sdk, and what it sends."""

from foxglove import Channel, Context, Parameter, Schema, Service, StatusLevel, start_server
from foxglove.websocket import (
    Capability,
    PlaybackState,
    ServerListener,
    WebSocketServer,
)

from rosbase import ConfigurationError
from rosbase_view.foxglove.graph import Links, to_graph

__all__ = ["ENCODING", "SCHEMA_ENCODING", "Server"]

ENCODING = "cdr"
SCHEMA_ENCODING = "ros2msg"
# Messages that wait for a client that does not read; then the oldest are dropped. The SDK knows a
# number only, and no bytes: a thousand images of a megabyte are a gigabyte.
_BACKLOG = 1024
_LIVE = (
    Capability.ClientPublish,
    Capability.ConnectionGraph,
    Capability.Parameters,
    Capability.Services,
    Capability.Time,
)
_IN_USE = "Address already in use"


class Server:
    """A server that may not have been started yet: it then sends nothing."""

    def __init__(self) -> None:
        """Prepare a server without topics."""
        self._context = Context()
        self._server: WebSocketServer | None = None
        self._links: Links | None = None

    def start(
        self,
        name: str,
        host: str,
        port: int,
        listener: ServerListener,
        time_range: tuple[int, int] | None = None,
    ) -> int:
        """Listen; return the port.

        Args:
            name: Name that clients show.
            host: Address on which to listen.
            port: Port; 0 for a free one.
            listener: Takes what clients ask for. The SDK calls it on threads that also send
                messages, so it must be quick.
            time_range: First and last date of a recording, in nanoseconds since 1970: it is played
                back. None for programs that run.

        Raises:
            ConfigurationError: The port is in use, or the address is wrong.
        """
        capabilities = _LIVE if time_range is None else (Capability.Time,)
        try:
            self._server = start_server(
                name=name,
                host=host,
                port=port,
                capabilities=list(capabilities),
                server_listener=listener,
                supported_encodings=[ENCODING],
                context=self._context,
                playback_time_range=time_range,
                message_backlog_size=_BACKLOG,
            )
        except RuntimeError as error:
            raise _cannot_listen(f"port {port} of {host}", error) from None
        return self._server.port

    def stop(self) -> None:
        """End all connections."""
        if self._server is not None:
            self._server.stop()

    def open_channel(self, topic: str, type_name: str, schema: str) -> Channel:
        """Offer a topic with messages in CDR."""
        return Channel(
            topic,
            message_encoding=ENCODING,
            schema=Schema(name=type_name, encoding=SCHEMA_ENCODING, data=schema.encode()),
            context=self._context,
        )

    def add_service(self, service: Service) -> None:
        """Offer a service."""
        if self._server is not None:
            self._server.add_services([service])

    def remove_service(self, name: str) -> None:
        """Offer a service no more."""
        if self._server is not None:
            self._server.remove_services([name])

    def send_parameters(self, parameters: list[Parameter]) -> None:
        """Send values to the clients that have subscribed to them."""
        if self._server is not None and parameters:
            self._server.publish_parameter_values(parameters)

    def send_links(self, links: Links) -> None:
        """Send the graph of nodes and topics, if it has changed."""
        if self._server is not None and links != self._links:
            self._links = links
            self._server.publish_connection_graph(to_graph(links))

    def send_time(self, now_ns: int) -> None:
        """Send the date, in nanoseconds since 1970."""
        if self._server is not None:
            self._server.broadcast_time(now_ns)

    def send_playback(self, state: PlaybackState) -> None:
        """Send where the playback is."""
        if self._server is not None:
            self._server.broadcast_playback_state(state)

    def warn(self, text: str, about: str) -> None:
        """Have clients show a line until `unwarn` removes it.

        Args:
            text: The line.
            about: Its subject: a later line about it takes its place.
        """
        if self._server is not None:
            self._server.publish_status(text, StatusLevel.Warning, about)

    def unwarn(self, about: str) -> None:
        """Remove a line."""
        if self._server is not None:
            self._server.remove_status([about])


def _cannot_listen(where: str, error: RuntimeError) -> ConfigurationError:
    if _IN_USE in str(error):
        return ConfigurationError(f"{where} is in use; choose another one: --foxglove PORT")
    reason = str(error).removeprefix("FoxgloveError: ")
    return ConfigurationError(f"cannot listen on {where}: {reason}")
