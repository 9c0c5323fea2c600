"""The transport `mqtt`: open, start, stop and close, from any thread and in any order."""

import threading

from imu_mqtt.config import MqttConfig
from imu_mqtt.network_thread import NetworkThread
from imu_mqtt.subscription import Subscription
from rosbase import (
    OnFrame,
    Stamper,
    Tally,
    Transport,
    TransportContext,
    TransportError,
    TransportHealth,
    TransportState,
)

__all__ = ["STOP_TIMEOUT_S", "MqttTransport"]

STOP_TIMEOUT_S = 2.0
"""Timeout of `stop` for an `on_frame`, and of `close` for a network, that does not return."""

_OPEN_TIMEOUT_S = 4.0
_ANSWER_TIMEOUT_S = 2.0


class MqttTransport(Transport):
    """A transport that reads whole payloads from a topic of a broker."""

    def __init__(self, config: MqttConfig, context: TransportContext) -> None:
        """Take the settings; touch no network yet."""
        self._config = config
        self._context = context
        self._tally = Tally()
        self._stamper = Stamper(context, self._tally)
        self._network: NetworkThread | None = None
        self._subscription: Subscription | None = None
        self._left_behind: list[NetworkThread] = []
        # Serialises the four calls. The network thread never takes it: it may be joined under it.
        self._lock = threading.RLock()

    def open(self) -> None:
        """Connect; with `wait_for_broker`, leave an absent broker to the network thread."""
        if self._caller() is not None:
            return
        with self._lock:
            if self._network is not None and not self._network.is_stopping:
                return
            # Of a thread that has failed both may be left.
            self._end_subscription()
            self._end_network()
            network = self._begin_network()
            failure = network.await_attempt(_OPEN_TIMEOUT_S)
            if failure is None or (self._config.wait_for_broker and not network.is_stopping):
                return
            self._end_network()
            raise failure

    def start(self, on_frame: OnFrame) -> None:
        """Subscribe; return when the broker has answered, if there is one."""
        if self._caller() is not None:
            return
        with self._lock:
            self.open()
            if self._subscription is not None or self._network is None:
                return
            subscription = Subscription(
                on_frame,
                self._tally,
                self._context,
                self._stamper,
                is_filter=self._config.is_filter,
            )
            self._network.want(subscription)
            refusal = subscription.await_answer(_ANSWER_TIMEOUT_S)
            if refusal is not None and not self._config.wait_for_broker:
                self._network.want(None)
                raise refusal
            self._subscription = subscription

    def stop(self) -> None:
        """Unsubscribe; wait for `on_frame` to return, except when called by it."""
        caller = self._caller()
        if caller is None:
            with self._lock:
                self._end_subscription()
        elif caller is self._network:
            self._end_subscription()

    def close(self) -> None:
        """Unsubscribe and disconnect."""
        caller = self._caller()
        if caller is not None:
            self.stop()
            caller.request_stop()
            return
        network = self._network
        if network is not None:
            # Whoever has the lock may be waiting for it to connect.
            network.request_stop()
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
        """Health of the transport."""
        return self._tally.health(self._state())

    def _state(self) -> TransportState:
        network = self._network
        if network is None or network.is_stopping:
            return TransportState.CLOSED
        return TransportState.CONNECTED if network.is_connected else TransportState.RECONNECTING

    def _caller(self) -> NetworkThread | None:
        """Return the network thread if it is the caller, from within `on_frame`.

        It may have been left behind.
        """
        networks = [self._network, *self._left_behind]
        return next((n for n in networks if n is not None and n.is_current_thread), None)

    def _begin_network(self) -> NetworkThread:
        try:
            network = NetworkThread(self._config, self._context, self._tally, self._stamper)
            # Known before it runs: `close` asks it to stop without waiting for `open`.
            self._network = network
            network.start()
        except (OSError, RuntimeError) as error:
            self._network = None
            raise TransportError(f"no thread can be started: {error}") from error
        return network

    def _end_subscription(self) -> None:
        subscription, self._subscription = self._subscription, None
        if self._network is not None:
            self._network.want(None)
        if subscription is not None and not subscription.end(STOP_TIMEOUT_S):
            self._context.logger.error(f"on_frame has not returned for {STOP_TIMEOUT_S:g} s")
            self._end_network(0.0)

    def _end_network(self, timeout_s: float = STOP_TIMEOUT_S) -> None:
        network = self._network
        if network is None:
            return
        # First, so that it is known at every moment.
        self._left_behind = [n for n in self._left_behind if not n.join(0.0)] + [network]
        self._network = None
        network.request_stop()
        if not network.join(timeout_s):
            self._context.logger.error("the network thread does not end; it is left behind")
