"""Where samples go: the three topics of REP-145, and what is the same in all messages."""

from collections.abc import Callable, Mapping
from typing import TypeAlias

from rosbase.contracts.imu_sender import ImuSender
from rosbase.imu.mapping import Sample
from rosbase.messages import (
    COVARIANCE_NOT_REPORTED,
    Covariance,
    Header,
    Imu,
    MagneticField,
    Time,
    Vector3,
)
from rosbase.roles.lifecycle_node import LifecyclePublisher

__all__ = ["Outlet", "Publishers"]

_NO_TURN = (0.0, 0.0, 0.0, 1.0)
_NO_VECTOR = (0.0, 0.0, 0.0)

_Absent: TypeAlias = tuple[bool, bool, bool]
"""Whether orientation, angular velocity and linear acceleration are missing."""


class Publishers:
    """The reader's publishers: `data`, `data_raw` and `mag`, under its namespace."""

    def __init__(self, create: Callable[[type, str], LifecyclePublisher], namespace: str) -> None:
        """Creates them."""
        self.data = create(Imu, f"{namespace}/data")
        self.data_raw = create(Imu, f"{namespace}/data_raw")
        self.mag = create(MagneticField, f"{namespace}/mag")


class Outlet:
    """Publishes samples: with an orientation on `data`, without one on `data_raw`."""

    def __init__(
        self,
        publishers: Publishers,
        prepare: Callable[[LifecyclePublisher, Imu], ImuSender],
        frame_id: str,
        covariances: Mapping[str, Covariance],
    ) -> None:
        """Prepares nothing yet.

        Args:
            publishers: Of the three topics.
            prepare: Makes what sends samples that are like a given message.
            frame_id: Of all messages.
            covariances: Of each quantity, where it is reported.
        """
        self._publishers = publishers
        self._prepare = prepare
        self._frame_id = frame_id
        self._covariances = covariances
        self._senders: dict[_Absent, tuple[LifecyclePublisher, ImuSender]] = {}

    def publish(self, sample: Sample, stamp_ns: int) -> bool:
        """Publishes what the sample has; tells whether the node was active, so that it went out."""
        orientation, angular, linear, field, _, _ = sample
        sent = False
        if orientation or angular or linear:
            absent = (orientation is None, angular is None, linear is None)
            publisher, send = self._senders.get(absent) or self._prepare_sender(absent)
            if publisher.is_enabled:
                send(stamp_ns, orientation or _NO_TURN, angular or _NO_VECTOR, linear or _NO_VECTOR)
                sent = True
        if field:
            sent = self._publish_field(field, stamp_ns) or sent
        return sent

    def _publish_field(self, field: tuple[float, ...], stamp_ns: int) -> bool:
        header = Header(Time.from_nanoseconds(stamp_ns), self._frame_id)
        covariance = self._covariances["magnetic_field"]
        return self._publishers.mag.publish(MagneticField(header, Vector3(*field), covariance))

    def _prepare_sender(self, absent: _Absent) -> tuple[LifecyclePublisher, ImuSender]:
        names = ("orientation", "angular_velocity", "linear_acceleration")
        turned, rate, force = (
            COVARIANCE_NOT_REPORTED if is_absent else self._covariances[name]
            for name, is_absent in zip(names, absent, strict=True)
        )
        template = Imu(
            header=Header(frame_id=self._frame_id),
            orientation_covariance=turned,
            angular_velocity_covariance=rate,
            linear_acceleration_covariance=force,
        )
        publisher = self._publishers.data_raw if absent[0] else self._publishers.data
        self._senders[absent] = publisher, self._prepare(publisher, template)
        return self._senders[absent]
