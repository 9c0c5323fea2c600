"""Real mosquitto, on a loopback port of the test's own."""

import os
import shutil
import signal
import socket
import subprocess
from collections.abc import Iterable
from pathlib import Path

from support.waiting import wait_until

__all__ = ["TOPIC", "Mosquitto", "can_connect", "free_port", "is_installed", "set_password"]

TOPIC = "esp32/imu"

# Debian puts it where only root's path leads.
_PATH = os.pathsep.join([os.environ.get("PATH", ""), "/usr/sbin", "/usr/local/sbin"])
_ANYBODY = "allow_anonymous true"


def is_installed() -> bool:
    """Whether this machine has the broker and its clients."""
    names = ("mosquitto", "mosquitto_pub", "mosquitto_sub", "mosquitto_passwd")
    return all(shutil.which(name, path=_PATH) for name in names)


def set_password(file: Path, user: str, password: str) -> None:
    """Puts a user into a password file of mosquitto."""
    file.touch(0o600)
    subprocess.run([_program("mosquitto_passwd"), "-b", str(file), user, password], check=True)


class Mosquitto:
    """A broker that can be killed, and started again where it was."""

    def __init__(self, folder: Path, *settings: str, more: str = _ANYBODY) -> None:
        """Starts it.

        Args:
            folder: For its configuration and its log.
            settings: Of its listener, which is on TCP.
            more: What else goes into its configuration.
        """
        self.port = free_port()
        self._configuration = folder / "mosquitto.conf"
        self._log = folder / "mosquitto.log"
        lines = [
            "per_listener_settings false", "persistence false", "log_type all",
            # It would give up what root may do, and read nothing in a test's folder.
            "user root", more, f"listener {self.port} 127.0.0.1", *settings,
        ]  # fmt: skip
        self._configuration.write_text("\n".join(lines) + "\n")
        self._process: subprocess.Popen[bytes] | None = None
        self.start()

    @property
    def address(self) -> str:
        return f"tcp://127.0.0.1:{self.port}"

    @property
    def log(self) -> str:
        return self._log.read_text()

    def start(self) -> None:
        """Returns when it listens."""
        command = [_program("mosquitto"), "-c", str(self._configuration)]
        with self._log.open("ab") as log:
            self._process = process = subprocess.Popen(command, stdout=log, stderr=log)

        def listens() -> bool:
            assert process.poll() is None, f"mosquitto has ended: {self.log}"
            return can_connect(self.port)

        wait_until(listens, "mosquitto to listen")

    def kill(self) -> None:
        """Ends it without a farewell to anybody."""
        self._end(signal.SIGKILL)

    def stop(self) -> None:
        """Ends it in an orderly way. Idempotent."""
        self._end(signal.SIGTERM)

    def reload(self) -> None:
        """Has it read its password files once more."""
        assert self._process is not None
        self._process.send_signal(signal.SIGHUP)

    def publish(self, payload: bytes, *options: str, topic: str = TOPIC) -> None:
        """Sends one message with mosquitto_pub, to the TCP listener."""
        self._client(
            "mosquitto_pub", "-t", topic, "-s" if payload else "-n", *options, payload=payload
        )

    def publish_lines(self, payloads: Iterable[bytes]) -> None:
        """Sends each as a message, with QoS 1, as fast as it goes."""
        self._client("mosquitto_pub", "-t", TOPIC, "-q", "1", "-l", payload=b"\n".join(payloads))

    def kept(self, topic: str) -> bytes:
        """The retained message of a topic; empty if there is none."""
        return self._client("mosquitto_sub", "-t", topic, "-N", "-C", "1", "-W", "1")

    def _client(self, name: str, *options: str, payload: bytes = b"") -> bytes:
        command = [_program(name), "-h", "127.0.0.1", "-p", str(self.port), *options]
        done = subprocess.run(command, input=payload, capture_output=True, check=False, timeout=20)
        # What mosquitto_sub ends with when there is nothing.
        assert done.returncode in (0, 27), done.stderr
        return done.stdout

    def _end(self, signum: int) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.send_signal(signum)
            try:
                process.wait(2)
            except subprocess.TimeoutExpired:
                # One that has only just begun misses a SIGTERM.
                process.kill()
                process.wait(20)


def free_port() -> int:
    """A port of this machine on which nobody listens."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
        return port


def can_connect(port: int) -> bool:
    """Whether somebody listens there."""
    try:
        socket.create_connection(("127.0.0.1", port), 1.0).close()
    except OSError:
        return False
    return True


def _program(name: str) -> str:
    path = shutil.which(name, path=_PATH)
    assert path, f"{name} is not installed"
    return path
