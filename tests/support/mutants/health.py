"""Mutants that do not say what is so."""

import threading

from attrs import evolve

from rosbase.contracts.transport import OnFrame, TransportHealth, TransportState
from support.mutants.mutant import Wrapped, mutant


class Reporting(Wrapped):
    """Reports its health by a rule of its own."""

    @property
    def health(self) -> TransportHealth:
        return self.report(self.inner.health)

    def report(self, health: TransportHealth) -> TransportHealth:
        raise NotImplementedError


@mutant("is-open-is-true-as-long-as-the-device-is-held", "is_open was true before open")
class IsAlwaysOpen(Wrapped):
    is_open = True


@mutant("is-open-is-true-as-long-as-the-device-is-held", "is_open was false after stop")
class StopGivesTheDeviceBack(Wrapped):
    def stop(self) -> None:
        self.inner.close()


@mutant("the-state-says-what-it-is-doing", "health.state was CONNECTED before open")
class IsAlwaysConnected(Reporting):
    def report(self, health: TransportHealth) -> TransportHealth:
        return evolve(health, state=TransportState.CONNECTED)


@mutant("health-counts-what-arrives", "frames was 0, not 20")
class CountsNoFrames(Reporting):
    def report(self, health: TransportHealth) -> TransportHealth:
        return evolve(health, frames=0)


@mutant("health-counts-what-arrives", "received_bytes was 20")
class CountsReadsForBytes(Reporting):
    def report(self, health: TransportHealth) -> TransportHealth:
        return evolve(health, received_bytes=health.frames)


@mutant("health-counts-what-arrives", "frame_errors was {'good': 20}")
class CountsGoodFramesAsErrors(Reporting):
    def report(self, health: TransportHealth) -> TransportHealth:
        return evolve(health, frame_errors={"good": health.frames})


@mutant("only-data-proves-that-a-device-is-alive", "before anything arrived")
class TakesAConnectionForData(Reporting):
    def report(self, health: TransportHealth) -> TransportHealth:
        return evolve(health, last_data_ns=self.context.clock.monotonic_ns())


@mutant("only-data-proves-that-a-device-is-alive", "it changed although nothing arrived")
class TakesAStartForData(Reporting):
    def report(self, health: TransportHealth) -> TransportHealth:
        is_something = health.last_data_ns is not None
        return evolve(
            health, last_data_ns=self.context.clock.monotonic_ns() if is_something else None
        )


@mutant("health-never-waits", "health has not returned after 0.4 s")
class HealthTakesTheLockOfStop(Reporting):
    def prepare(self) -> None:
        self.lock = threading.Lock()

    def stop(self) -> None:
        with self.lock:
            self.inner.stop()

    def report(self, health: TransportHealth) -> TransportHealth:
        with self.lock:
            return health


@mutant("counts-go-on-over-stop-and-close", "frames was 5, received_bytes")
class CountsSinceTheLastStart(Wrapped):
    before = TransportHealth()

    def start(self, on_frame: OnFrame) -> None:
        self.before = self.inner.health
        self.inner.start(on_frame)

    @property
    def health(self) -> TransportHealth:
        health = self.inner.health
        return evolve(
            health,
            frames=health.frames - self.before.frames,
            received_bytes=health.received_bytes - self.before.received_bytes,
        )


@mutant("health-counts-what-arrives", "received_bytes was")
class CountsTooManyBytes(Reporting):
    def report(self, health: TransportHealth) -> TransportHealth:
        return evolve(health, received_bytes=health.received_bytes * 1_000)
