"""The transport `mqtt`: open, start, stop and close, from any thread and in any order."""

import threading

from imu_mqtt.config import MqttConfig
from imu_mqtt.network_thread import NetworkThread
from imu_mqtt.subscription import Subscription
from rosbase.errors import TransportError
from rosbase.transport import (
    OnFrame,
    Tally,
    Transport,
    TransportContext,
    TransportHealth,
    TransportState,
)

__all__ = ["STOP_TIMEOUT_S", "MqttTransport"]

STOP_TIMEOUT_S = 2.0
"""How long `stop` waits for an `on_frame` that does not return."""

_OPEN_TIMEOUT_S = 4.0
_ANSWER_TIMEOUT_S = 2.0


class MqttTransport(Transport):
    """Whole payloads from a topic of a broker."""

    def __init__(self, config: MqttConfig, context: TransportContext) -> None:
        """Touches nothing yet."""
        self._config = config
        self._context = context
        self._tally = Tally()
        self._network: NetworkThread | None = None
        self._subscription: Subscription | None = None
        self._left_behind: list[NetworkThread] = []
        # Serialises the four calls. The network thread never takes it: it may be joined under it.
        self._lock = threading.RLock()

    def open(self) -> None:
        """Connects; with `wait_for_broker` an absent one is left to the network thread."""
        if self._on_network_thread():
            return
        with self._lock:
            if self._network is not None and not self._network.is_stopping:
                return
            self._end_network()
            network = NetworkThread(self._config, self._context, self._tally)
            try:
                network.start()
            except RuntimeError as error:
                raise TransportError(f"no thread can be started: {error}") from error
            self._network = network
            failure = network.await_attempt(_OPEN_TIMEOUT_S)
            if failure is None or (self._config.wait_for_broker and failure.retryable):
                return
            self._end_network()
            raise failure

    def start(self, on_frame: OnFrame) -> None:
        """Subscribes; returns when the broker has answered, if there is one."""
        if self._on_network_thread():
            return
        with self._lock:
            self.open()
            if self._subscription is not None or self._network is None:
                return
            subscription = Subscription(
                on_frame, self._tally, self._context, is_filter=self._config.is_filter
            )
            self._network.want(subscription)
            refusal = subscription.await_answer(_ANSWER_TIMEOUT_S)
            if refusal is not None:
                self._network.want(None)
                raise refusal
            self._subscription = subscription

    def stop(self) -> None:
        """Unsubscribes; waits for `on_frame` to return, except when called by it."""
        if self._on_network_thread():
            self._end_subscription()
            return
        with self._lock:
            self._end_subscription()

    def close(self) -> None:
        """Unsubscribes and disconnects."""
        if self._on_network_thread():
            self._end_subscription()
            if self._network is not None:
                self._network.request_stop()
            return
        with self._lock:
            self._end_subscription()
            self._end_network()

    @property
    def is_open(self) -> bool:
        """Whether there is a connection at this moment."""
        network = self._network
        return network is not None and network.is_connected

    @property
    def health(self) -> TransportHealth:
        """How it is doing."""
        return self._tally.health(self._state())

    def _state(self) -> TransportState:
        network = self._network
        if network is None or network.is_stopping:
            return TransportState.CLOSED
        return TransportState.CONNECTED if network.is_connected else TransportState.RECONNECTING

    def _on_network_thread(self) -> bool:
        networks = [self._network, *self._left_behind]
        return any(network is not None and network.is_current_thread for network in networks)

    def _end_subscription(self) -> None:
        subscription, self._subscription = self._subscription, None
        if self._network is not None:
            self._network.want(None)
        if subscription is not None and not subscription.end(STOP_TIMEOUT_S):
            self._context.logger.error(f"on_frame has not returned for {STOP_TIMEOUT_S:g} s")

    def _end_network(self) -> None:
        network, self._network = self._network, None
        if network is None:
            return
        network.request_stop()
        if not network.join(STOP_TIMEOUT_S):
            self._left_behind = [n for n in self._left_behind if not n.join(0.0)] + [network]
            self._context.logger.error("the network thread does not end; it is left behind")
