"""Texts about a run: the line while it goes on, and the summary at its end."""

from collections.abc import Iterator, Sequence

from rosbase.cli.panel.drawing import View
from rosbase.cli.panel.fields import Field
from rosbase.imu.covariance import measured
from rosbase.imu.health import HealthLevel
from rosbase.imu.reader import ImuReader
from rosbase.lifecycle import State
from rosbase.messages import Imu, MagneticField
from rosbase.runtime.histogram import Histogram

__all__ = ["count_fields", "note_on", "status_line", "summary_lines", "view_of"]

_COLOURS = {HealthLevel.OK: "green", HealthLevel.WARN: "yellow", HealthLevel.ERROR: "red"}


def status_line(
    reader: ImuReader, last: Imu | MagneticField | None, dropped: int, rate_hz: float
) -> str:
    """Return the state of the reader, its rate, the lost samples, and the last sample."""
    state = reader.get_state()
    if state is not State.ACTIVE:
        return state.label
    counts = reader.counts
    parts = [
        f"{rate_hz:7.1f} Hz",
        f"published {counts.published}",
        f"rejected {counts.rejected}",
        f"dropped {dropped}",
    ]
    if last is not None and (shown := _sample(last)):
        parts.append(shown)
    health = reader.check_health()
    if health.level is not HealthLevel.OK:
        parts.insert(0, f"{health.level.name} {health.message}")
    return "  ".join(parts)


def view_of(
    reader: ImuReader,
    last: Imu | MagneticField | None,
    title: Sequence[Field],
    counts: Sequence[Field],
    note: tuple[str, str] = ("", ""),
) -> View:
    """Return the contents of the panel; without a note, it shows the reader's state and health."""
    text, colour = note if note[0] else note_on(reader)
    return View(title, counts, last, text, (colour,) if colour else ())


def note_on(reader: ImuReader) -> tuple[str, str]:
    """Return a sentence on the reader's health, and its colour."""
    state = reader.get_state()
    if state is not State.ACTIVE:
        return state.label, "yellow"
    health = reader.check_health()
    return f"{health.level.name}: {health.message}", _COLOURS.get(health.level, "red")


def count_fields(
    reader: ImuReader,
    rate_hz: float,
    latency: Histogram | None,
    lost: tuple[str, int],
    sent: int | None = None,
) -> list[Field]:
    """Return the counts of the samples, the most important first.

    Args:
        reader: The reader with the counts.
        rate_hz: Samples per second, of late.
        latency: From the stamp to the subscriber, in nanoseconds, if that can be measured.
        lost: Word for the losses, and their number.
        sent: Number of samples that the device has sent, where that is known.
    """
    counts = reader.counts
    fields = [Field("rate", f"{rate_hz:.1f} Hz")]
    if latency is not None and latency.count:
        fields.append(Field("latency", f"{_ms(latency, 50):.2f} ms"))
    fields += [
        Field(lost[0], str(lost[1]), ("red",) if lost[1] else ()),
        Field("published", str(counts.published)),
        Field("rejected", str(counts.rejected), ("yellow",) if counts.rejected else ()),
    ]
    if sent is not None:
        fields.append(Field("sent", str(sent)))
    return [*fields, Field("received", str(counts.received))]


def summary_lines(reader: ImuReader, dropped: int, latency: Histogram | None) -> Iterator[str]:
    """Return one count per line, the word first; the latency in milliseconds, if it was measured.

    The health of the reader when it was last active follows, if something was wrong.
    """
    counts = reader.counts
    yield f"received {counts.received}"
    yield f"published {counts.published}"
    yield f"rejected {counts.rejected}"
    yield f"ignored {counts.ignored}"
    for reason, number in sorted(counts.by_reason.items()):
        yield f"{reason} {number}"
    for reason, number in sorted(counts.left_out.items()):
        yield f"left_out_{reason} {number}"
    if counts.time_unusable:
        yield f"time_unusable {counts.time_unusable}"
    if counts.clock_unusable:
        yield f"clock_unusable {counts.clock_unusable}"
    yield f"dropped {dropped}"
    transport = reader.transport_health
    for reason, number in sorted(transport.link_errors.items()):
        yield f"link_{reason} {number}"
    yield f"reconnects {transport.reconnects}"
    if transport.late_frames:
        yield f"late_frames {transport.late_frames}"
    if transport.clock_steps:
        yield f"clock_steps {transport.clock_steps}"
    if latency is not None and latency.count:
        yield f"latency_p50_ms {_ms(latency, 50):.3f}"
        yield f"latency_p99_ms {_ms(latency, 99):.3f}"
    health = reader.last_health
    if health.level is not HealthLevel.OK:
        yield f"health {health.level.name} {health.message}"


def _ms(latency: Histogram, percent: float) -> float:
    return latency.percentile(percent) / 1e6


def _sample(message: Imu | MagneticField) -> str:
    if isinstance(message, MagneticField):
        field = message.magnetic_field
        return f"mag {field.x * 1e6:8.2f} {field.y * 1e6:8.2f} {field.z * 1e6:8.2f} uT"
    a = measured(message.linear_acceleration, message.linear_acceleration_covariance)
    w = measured(message.angular_velocity, message.angular_velocity_covariance)
    parts = []
    if a is not None:
        parts.append(f"accel {a.x:6.2f} {a.y:6.2f} {a.z:6.2f} m/s^2")
    if w is not None:
        parts.append(f"gyro {w.x:6.2f} {w.y:6.2f} {w.z:6.2f} rad/s")
    return "  ".join(parts)
