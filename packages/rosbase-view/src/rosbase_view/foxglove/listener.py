"""The requests of clients, from the SDK to the objects that do them."""

from collections.abc import Callable

from foxglove import Parameter
from foxglove.websocket import ChannelView, Client, ClientChannel, ServerListener

from rosbase_view.foxglove.channels import Channels
from rosbase_view.foxglove.client_topics import ClientTopics
from rosbase_view.foxglove.parameter_desk import ParameterDesk

__all__ = ["Listener"]


class Listener(ServerListener):
    """Is called by threads of the SDK that send messages to all clients, so it never waits long."""

    def __init__(
        self,
        channels: Channels,
        parameters: ParameterDesk,
        client_topics: ClientTopics,
        poke: Callable[[], object],
    ) -> None:
        """Pass on what is asked.

        Args:
            channels: The topics that clients hear.
            parameters: The parameters that they read and write.
            client_topics: The topics on which they publish.
            poke: Called when clients begin or end to listen.
        """
        self._channels, self._parameters = channels, parameters
        self._client_topics = client_topics
        self._poke = poke

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        """Begin to hear a topic."""
        self._channels.count_listener(channel.topic)
        self._poke()

    def on_unsubscribe(self, client: Client, channel: ChannelView) -> None:
        """End hearing a topic, if nobody else listens."""
        self._poke()

    def on_client_advertise(self, client: Client, channel: ClientChannel) -> None:
        """Learn the topic on which a client is about to publish."""
        self._client_topics.advertise((client.id, channel.id), channel)

    def on_client_unadvertise(self, client: Client, client_channel_id: int) -> None:
        """End the publisher of a client."""
        self._client_topics.unadvertise((client.id, client_channel_id))

    def on_message_data(self, client: Client, client_channel_id: int, data: bytes) -> None:
        """Publish the message of a client."""
        self._client_topics.publish((client.id, client_channel_id), data)

    def on_get_parameters(
        self, client: Client, param_names: list[str], request_id: str | None = None
    ) -> list[Parameter]:
        """Return the parameters with those names; all of them if there are no names."""
        return self._parameters.get(param_names)

    def on_set_parameters(
        self, client: Client, parameters: list[Parameter], request_id: str | None = None
    ) -> list[Parameter]:
        """Set parameters; return what they are then."""
        return self._parameters.set(parameters)

    def on_parameters_subscribe(self, param_names: list[str]) -> None:
        """Begin to tell of changes."""
        self._parameters.subscribe(param_names)

    def on_parameters_unsubscribe(self, param_names: list[str]) -> None:
        """End telling of changes."""
        self._parameters.unsubscribe(param_names)
