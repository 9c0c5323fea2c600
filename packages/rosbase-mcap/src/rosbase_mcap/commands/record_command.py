"""`rosbase record`: record a program that already runs, or have it write what it keeps."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rosbase import ConfigurationError, SystemClock, make_logger
from rosbase.control import connect
from rosbase.control.fleet import Fleet
from rosbase.control.gathering import ask_one
from rosbase_mcap.attached_parameters import PARAMETER_EVENTS, record_parameters
from rosbase_mcap.attached_topics import AttachedTopics
from rosbase_mcap.channel_table import ChannelTable
from rosbase_mcap.commands.intermixed import allow_intermixed
from rosbase_mcap.commands.stop_request import stop_request
from rosbase_mcap.compression import COMPRESSIONS
from rosbase_mcap.errors import McapError
from rosbase_mcap.file_sink import FileSink
from rosbase_mcap.log_channel import LOG_TOPIC, LogChannel
from rosbase_mcap.quantities import size_bytes, span_ns
from rosbase_mcap.recorder import Recorder
from rosbase_mcap.ring import Ring
from rosbase_mcap.splitting import Split

__all__ = ["configure", "run"]

# New topics are looked for so often.
_LOOK_NS = 500_000_000
# A signal is noticed after this time.
_WAIT_S = 0.1
_RING_BYTES = 256 << 20
# It has no beginning, so a program cannot be replayed from it; its topics can.
_FACTS = {"attached": "true", "replays_program": "false"}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("name", metavar="NAME", help="name or process id of the program")
    parser.add_argument("topics", nargs="*", metavar="TOPIC", help="topics; by default, all")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="the recording")
    parser.add_argument("--split-size", type=_positive(size_bytes), default=0, help="such as 1GB")
    parser.add_argument("--split-time", type=_positive(span_ns), default=0, help="such as 10min")
    parser.add_argument("--duration", type=span_ns, help="end after this time, such as 60s")
    parser.add_argument(
        "--last",
        type=_positive(span_ns),
        help="keep only this time, such as 60s, and write it at the end",
    )
    parser.add_argument("--compression", choices=COMPRESSIONS[1:], default="")
    parser.add_argument(
        "--save",
        action="store_true",
        help="have a program that was started with --record-last write its recording now",
    )
    allow_intermixed(parser)


def run(arguments: Any) -> int:
    """Record until the program ends, the time is over, or Ctrl-C."""
    # A name of digits is a process id.
    name = int(arguments.name) if arguments.name.isdecimal() else arguments.name
    fleet = connect(name)
    if arguments.save:
        return _save(fleet)
    topics = [f"/{topic.lstrip('/')}" for topic in arguments.topics]
    missing = _missing(fleet, topics)
    path = arguments.output or _default_path(arguments.name)
    table, logger = ChannelTable(), make_logger("record")
    sink = _sink(arguments, path, table)
    recorder = Recorder(sink, table, logger)
    if missing:
        logger.warning(missing)
    attached = AttachedTopics(fleet, recorder, SystemClock(), logger.warning, topics)
    recorder.start()
    try:
        with stop_request() as is_asked:
            if not topics or PARAMETER_EVENTS in topics:
                record_parameters(fleet, recorder, SystemClock())
            if not topics or LOG_TOPIC in topics:
                pids = [process["pid"] for process in fleet.processes()]
                attached.hear_log(pids, LogChannel(recorder))
            _record(attached, recorder, arguments.duration, is_asked)
    finally:
        attached.close()
        recorder.stop()
    number = _saved(sink, path) if isinstance(sink, Ring) else recorder.written
    lost = attached.lost + recorder.dropped
    print(f"{path}: {number} messages" + (f", {lost} are missing" if lost else ""))
    return 1 if recorder.is_broken else 0


def _positive(read: Callable[[str], int]) -> Callable[[str], int]:
    """Return a function that refuses 0, too."""

    def read_positive(text: str) -> int:
        if value := read(text):
            return value
        raise argparse.ArgumentTypeError(f"{text!r} is not more than 0")

    return read_positive


def _missing(fleet: Fleet, topics: list[str]) -> str:
    """Return a line about topics that no program has yet; empty if there are none.

    Raises:
        ConfigurationError: The programs have none of the topics.
    """
    if not topics:
        return ""
    there = {topic["name"] for topic in fleet.topics()} | {PARAMETER_EVENTS, LOG_TOPIC}
    missing = [topic for topic in topics if topic not in there]
    if not missing:
        return ""
    line = f"no topic {', '.join(missing)}; there are: {', '.join(sorted(there))}"
    if len(missing) == len(topics):
        raise ConfigurationError(line)
    return line


def _sink(arguments: Any, path: Path, table: ChannelTable) -> FileSink | Ring:
    """Return where the messages go.

    Raises:
        McapError: There is a file of that name, or it cannot be created.
    """
    compression = arguments.compression
    if arguments.last is not None:
        if path.exists():
            raise McapError(f"{path}: there is such a file already")
        limits = {"keep_ns": arguments.last, "most_bytes": _RING_BYTES}
        return Ring(table, _FACTS, **limits, compression=compression)
    split = Split(arguments.split_size, arguments.split_time)
    try:
        return FileSink(path, table, _FACTS, split=split, compression=compression)
    except OSError as error:
        raise McapError(f"{path}: {error.strerror or error}") from error


def _save(fleet: Fleet) -> int:
    """Have programs write what they keep in memory; print the files."""
    for process in fleet.processes():
        for file in ask_one(process["pid"], "recording.save", {})[0]["files"]:
            print(file)
    return 0


def _saved(ring: Ring, path: Path) -> int:
    try:
        return ring.save(path)
    except OSError as error:
        raise McapError(f"{path}: {error.strerror or error}") from error


def _record(
    attached: AttachedTopics,
    recorder: Recorder,
    duration_ns: int | None,
    is_asked_to_stop: Callable[[], bool],
) -> None:
    """Record until an end."""
    clock = SystemClock()
    look_ns = clock.monotonic_ns()
    end_ns = None if duration_ns is None else look_ns + duration_ns
    while not (recorder.is_broken or is_asked_to_stop()):
        now_ns = clock.monotonic_ns()
        if end_ns is not None and now_ns >= end_ns:
            break
        if now_ns >= look_ns:
            attached.look()
            look_ns = now_ns + _LOOK_NS
        if attached.is_over:
            break
        attached.take(_WAIT_S)


def _default_path(name: str) -> Path:
    stem = name.strip("/").replace("/", "_")
    if not stem:
        raise ConfigurationError("give the recording a name: -o FILE.mcap")
    for number in range(10_000):
        path = Path(f"{stem}_{number}.mcap" if number else f"{stem}.mcap")
        if not path.exists():
            return path
    raise ConfigurationError(f"there are too many recordings of {name}: choose one with -o")
