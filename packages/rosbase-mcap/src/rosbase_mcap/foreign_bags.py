"""Bags of ROS that are no MCAP file, through `rosbags`: rosbag2 in SQLite, folders, and ROS 1."""

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosbase import NotInstalledError
from rosbase.text.printable import one_line
from rosbase_mcap.bags import Bag, BagMessage, BagTopic
from rosbase_mcap.errors import McapError

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
    from rosbags.interfaces import Connection

__all__ = ["open_foreign_bag"]

_HOW_TO_INSTALL = "pip install 'rosbags>=0.11'"

_TRANSIENT_LOCAL = "TRANSIENT_LOCAL"


@contextmanager
def open_foreign_bag(path: Path) -> Iterator[Bag]:
    """Open a bag with `rosbags`.

    Raises:
        McapError: It cannot be read.
        NotInstalledError: `rosbags` is not installed.
    """
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise NotInstalledError(f"{path}: bags need rosbags: {_HOW_TO_INSTALL}") from None
    if path.is_dir() and not (path / "metadata.yaml").exists():
        raise McapError(f"{path}: this folder is no bag: it has no metadata.yaml")
    try:
        # Older bags have no definitions of their types.
        reader = AnyReader([path], default_typestore=get_typestore(Stores.LATEST))
        reader.open()
    except (AnyReaderError, OSError, ValueError) as error:
        raise McapError(f"{path}: {one_line(str(error))}") from error
    try:
        yield _ForeignBag(path, reader, AnyReaderError)
    finally:
        reader.close()


class _ForeignBag:
    """A bag that `rosbags` has opened."""

    def __init__(self, path: Path, reader: "AnyReader", fault: type[Exception]) -> None:
        self._path, self._reader, self._fault = path, reader, fault
        self._to_cdr = (lambda data, _: bytes(data)) if reader.is2 else _from_ros_1(reader)
        self.topics = {
            _full(connection.topic): BagTopic(connection.msgtype, _is_latched(connection))
            for connection in reader.connections
        }

    @property
    def start_ns(self) -> int:
        """Date of the first message; 0 if there is none."""
        return self._reader.start_time if self._reader.message_count else 0

    def messages(self, topics: Collection[str]) -> Iterator[BagMessage]:
        """Yield the messages of some topics, in the order of their dates."""
        wanted = frozenset(topics)
        chosen = [one for one in self._reader.connections if _full(one.topic) in wanted]
        # No connection at all would be all of them.
        found = self._reader.messages(chosen) if chosen else iter(())
        while True:
            try:
                connection, log_ns, data = next(found)
                message = self._to_cdr(data, connection.msgtype)
            except StopIteration:
                return
            except (self._fault, ValueError) as error:
                raise McapError(f"{self._path}: {one_line(str(error))}") from error
            yield BagMessage(_full(connection.topic), log_ns, message)


def _is_latched(connection: "Connection") -> bool:
    # Of rosbag2, a list of profiles; of ROS 1, a number.
    profiles = getattr(connection.ext, "offered_qos_profiles", ())
    named = any(one.durability.name == _TRANSIENT_LOCAL for one in profiles)
    return named or bool(getattr(connection.ext, "latching", 0))


def _full(topic: str) -> str:
    # ROS 1 records names as they were written.
    return topic if topic.startswith("/") else f"/{topic}"


def _from_ros_1(reader: "AnyReader") -> Callable[[Any, str], bytes]:
    """Return the function that makes a message of ROS 2 of one of ROS 1.

    Its header has a number more in ROS 1, and some of its types have other names of fields.
    """
    from rosbags.convert.converter import migrate_bytes
    from rosbags.typesys import Stores, get_typestore

    own = reader.typestore
    ros_2 = get_typestore(Stores.LATEST)
    ros_2.register({name: of for name, of in own.fielddefs.items() if name not in ros_2.fielddefs})
    cache: dict[str, object] = {}

    def to_cdr(data: Any, name: str) -> bytes:
        stores = own, ros_2, name, name
        return bytes(migrate_bytes(*stores, cache, data, src_is2=False, dst_is2=True))

    return to_cdr
