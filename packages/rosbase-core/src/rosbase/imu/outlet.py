"""Publish samples on the three topics of REP-145, with their stamps, and count the outcomes."""

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, TypeAlias

from rosbase.contracts.node_connection import Sender
from rosbase.imu.counts import Counts
from rosbase.imu.mapping import Sample
from rosbase.messages import (
    COVARIANCE_NOT_REPORTED,
    STAMPS_END_NS,
    Covariance,
    Header,
    Imu,
    MagneticField,
)
from rosbase.roles.lifecycle_publisher import LifecyclePublisher

__all__ = ["VARYING", "Outlet", "Publishers"]

_MEASURED = ("orientation", "angular_velocity", "linear_acceleration")
"""Quantities of an Imu, in the order of `_Absent`."""

VARYING = ("header.stamp", *_MEASURED)
"""Fields of an Imu that differ from one sample to the next."""

_NO_TURN = (0.0, 0.0, 0.0, 1.0)
_NO_VECTOR = (0.0, 0.0, 0.0)

_Absent: TypeAlias = tuple[bool, bool, bool]
"""Whether orientation, angular velocity and linear acceleration are missing."""


class Publishers:
    """The reader's publishers: `data`, `data_raw` and `mag`, under its namespace."""

    data: LifecyclePublisher[Imu]
    data_raw: LifecyclePublisher[Imu]
    mag: LifecyclePublisher[MagneticField]

    def __init__(
        self, create: Callable[[type, str], LifecyclePublisher[Any]], namespace: str
    ) -> None:
        """Create the publishers."""
        self.data = create(Imu, f"{namespace}/data")
        self.data_raw = create(Imu, f"{namespace}/data_raw")
        self.mag = create(MagneticField, f"{namespace}/mag")


class Outlet:
    """Publishes samples: with an orientation on `data`, without one on `data_raw`."""

    def __init__(
        self,
        publishers: Publishers,
        prepare: Callable[[LifecyclePublisher[Any], Any, Sequence[str]], Sender],
        frame_id: str,
        covariances: Mapping[str, Covariance],
        counts: Counts,
        mapped: Collection[str],
    ) -> None:
        """Prepare the senders of samples that lack nothing; others when the first one comes.

        Args:
            publishers: Publishers of the three topics.
            prepare: Makes a sender of messages that differ from a given one in the fields that are
                named.
            frame_id: Frame of all messages.
            covariances: Covariance of each quantity, where it is reported.
            counts: Counts the outcome of each sample.
            mapped: Quantities that a sample may have.
        """
        self._publishers = publishers
        self._prepare = prepare
        self._frame_id = frame_id
        self._covariances = covariances
        self._counts = counts
        self._senders: dict[_Absent, Sender] = {}
        # All three are enabled together.
        self._gate = publishers.data
        # Not while the first sample waits for them.
        orientation, angular, linear = (name not in mapped for name in _MEASURED)
        if not (orientation and angular and linear):
            self._prepare_sender((orientation, angular, linear))
        self._field_sender: Sender | None = None
        if "magnetic_field" in mapped:
            self._prepare_field_sender()

    def publish(self, sample: Sample, stamp_ns: int) -> bool:
        """Publish the quantities of the sample, and count it; return whether it was published.

        A stamp that ROS cannot carry is published as zero. An exception counts as `not_sent`.
        """
        counts = self._counts
        if not self._gate.is_enabled:
            counts.add("not_active")
            return False
        if not 0 < stamp_ns < STAMPS_END_NS:
            stamp_ns = 0
            counts.clock_unusable += 1
        orientation, angular, linear, field, _, _ = sample
        sent = False
        try:
            if orientation or angular or linear:
                absent = (orientation is None, angular is None, linear is None)
                send = self._senders.get(absent) or self._prepare_sender(absent)
                turned, rate = orientation or _NO_TURN, angular or _NO_VECTOR
                sent = send(stamp_ns, turned, rate, linear or _NO_VECTOR) is not False
            if field:
                send = self._field_sender or self._prepare_field_sender()
                sent = send(stamp_ns, field) is not False or sent
        except Exception:
            counts.add("not_sent")
            raise
        if sent:
            counts.published += 1
        else:
            counts.add("not_sent")
        return sent

    def _prepare_sender(self, absent: _Absent) -> Sender:
        turned, rate, force = (
            COVARIANCE_NOT_REPORTED if is_absent else self._covariances[name]
            for name, is_absent in zip(_MEASURED, absent, strict=True)
        )
        template = Imu(
            header=Header(frame_id=self._frame_id),
            orientation_covariance=turned,
            angular_velocity_covariance=rate,
            linear_acceleration_covariance=force,
        )
        publisher = self._publishers.data_raw if absent[0] else self._publishers.data
        self._senders[absent] = self._prepare(publisher, template, VARYING)
        return self._senders[absent]

    def _prepare_field_sender(self) -> Sender:
        template = MagneticField(
            header=Header(frame_id=self._frame_id),
            magnetic_field_covariance=self._covariances["magnetic_field"],
        )
        varying = ("header.stamp", "magnetic_field")
        self._field_sender = self._prepare(self._publishers.mag, template, varying)
        return self._field_sender
