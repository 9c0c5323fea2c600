"""Text from outside in real commands: the bytes that come out, on a terminal and in a pipe."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from support.command import ROSBASE, run_rosbase
from support.mqtt import SUBSCRIBE, Peer, ScriptedBroker, packet, publish_packet
from support.program import running
from support.samples import GOOD, GOOD_FRAME
from support.serial_port import PluggablePort
from support.terminal import assert_harmless, on_terminal
from support.waiting import wait_until

CLEAR, TITLE, BACK = "\x1b[2J", "\x1b]0;mine\x07", "\u202e"
FORGED = "[INFO] [manager]: all is well"


def records(lines: list[str]) -> list[str]:
    return [line for line in lines if line.startswith("[")]


TOPICS = {
    f"lab/{CLEAR}": r"dropping messages to a topic MQTT forbids: lab/\x1b[2J",
    f"lab/{BACK}umi": r"reading lab/\u202eumi",
    f"lab/a\n{FORGED}": rf"dropping messages to a topic MQTT forbids: lab/a\n{FORGED}",
    "lab/" + "x" * 60_000: "reading lab/" + "x" * 190,
}


@pytest.mark.parametrize(("topic", "said"), TOPICS.items(), ids=["clear", "back", "line", "long"])
def test_a_topic_of_any_text_is_named_and_does_nothing_else(topic: str, said: str) -> None:
    def behave(peer: Peer) -> None:
        peer.accept()
        peer.serve(until=SUBSCRIBE)
        while True:
            peer.send(publish_packet(topic.encode(), GOOD_FRAME))
            peer.pause(0.02)

    with (
        ScriptedBroker(behave) as broker,
        on_terminal(
            ROSBASE, "imu", "-p", "comm_t:=mqtt", "-p", f"server_address:={broker.address}",
            "-p", "mqtt_topic:=lab/#",
        ) as reader,
    ):  # fmt: skip
        reader.waits_for(said)
        lines = assert_harmless(reader.end())
    assert not [line for line in lines if line.startswith(FORGED)]
    assert max(map(len, records(lines))) < 400


PAYLOADS = {
    "a title": TITLE.encode(),
    "another line": f"hello\u2028{FORGED}".encode(),
    "JSON of such keys": json.dumps({CLEAR + BACK: 1}, ensure_ascii=False).encode(),
    "JSON of such values": json.dumps(
        GOOD | {"linear_acceleration": {"x": CLEAR, "y": BACK, "z": 0}}, ensure_ascii=False
    ).encode(),
    "broken JSON": b'{"a": ' + CLEAR.encode() + b"}",
    "huge": b'{"' + b"\x9b" * 60_000,
}


@pytest.mark.parametrize("payload", PAYLOADS.values(), ids=PAYLOADS)
def test_a_payload_of_any_text_is_quoted_and_does_nothing_else(
    port: PluggablePort, payload: bytes
) -> None:
    port.plug()
    with on_terminal(ROSBASE, "imu", "-p", f"device_path:={port.path}") as reader:
        reader.waits_for("opened")

        def is_dropped() -> bool:
            # Again and again: what arrives before the node is active is discarded.
            port.write(payload + b"\n" + GOOD_FRAME + b"\n")
            return b"dropped" in reader.shown

        wait_until(is_dropped, "the word about the payload")
        lines = assert_harmless(reader.end())
    assert max(map(len, records(lines))) < 700


MISTAKES: dict[str, Callable[[Path], list[str]]] = {
    "a value": lambda folder: ["imu", "-p", f"plausibility:={CLEAR}\n{FORGED}"],
    "a long value": lambda folder: ["imu", "-p", "plausibility:=" + TITLE * 5_000],
    "a name": lambda folder: ["imu", "-p", f"{BACK}\n{FORGED}:=1"],
    "no value": lambda folder: ["imu", "-p", CLEAR],
    "a preset": lambda folder: ["imu", "-p", f"preset:={BACK}{TITLE}"],
    "a transport": lambda folder: ["imu", "-p", f"comm_t:={CLEAR}"],
    "a backend": lambda folder: ["imu", "--backend", CLEAR],
    "a path of the mapping": lambda folder: ["imu", "-p", f"linear_acceleration.paths:=[{CLEAR}[]"],
    "an option": lambda folder: ["imu", f"--{CLEAR}"],
    "a command": lambda folder: [f"{BACK}\n{FORGED}"],
    "a file that is not there": lambda folder: ["imu", "--params-file", f"{CLEAR}\n{FORGED}"],
    "a file of another kind": lambda folder: ["imu", "--params-file", str(toml(folder, CLEAR))],
    "a value in a file": lambda folder: [
        "imu", "--params-file", str(toml(folder, r'plausibility = "\u001b[2J\n[INFO]"')),
    ],
    "a name in a file": lambda folder: [
        "imu", "--params-file", str(toml(folder, r'"\u001b[2J\u202e" = 1')),
    ],
}  # fmt: skip


def toml(folder: Path, text: str) -> Path:
    file = folder / f"{BACK}{CLEAR}.toml"
    file.write_text(text)
    return file


@pytest.mark.parametrize("make", MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_of_any_text_is_one_line_and_status_2(
    tmp_path: Path, make: Callable[[Path], list[str]]
) -> None:
    done = run_rosbase(*make(tmp_path))
    (line, nothing) = assert_harmless(done.stderr.encode())
    assert (done.returncode, done.stdout, nothing) == (2, "", "")
    assert line.startswith("rosbase")
    assert len(line) < 2_000


DEVICES = [f"/dev/{CLEAR}", f"/dev/a\n{FORGED}", f"/dev/{BACK}imu", "/dev/" + "x" * 3_000]


@pytest.mark.parametrize("path", DEVICES, ids=["clear", "line", "back", "long"])
def test_a_device_of_any_name_is_named_and_does_nothing_else(path: str) -> None:
    done = run_rosbase("imu", "-p", f"device_path:={path}", "--duration", "0.5")
    lines = assert_harmless(done.stderr.encode() + done.stdout.encode())
    assert not [line for line in lines if line.startswith(FORGED)]
    assert max(map(len, lines)) < 1_500


def test_a_broker_that_refuses_in_any_words_is_quoted_in_a_line_of_the_doctors(
    tmp_path: Path,
) -> None:
    words = f"{CLEAR}\n{FORGED}{BACK}".encode()

    def refuses(peer: Peer) -> None:
        peer.receive()
        properties = b"\x1f" + len(words).to_bytes(2, "big") + words
        peer.send(packet(0x20, b"\0\x87" + bytes([len(properties)]) + properties))

    with ScriptedBroker(refuses) as broker:
        done = run_rosbase(
            "doctor", "-p", f"server_address:={broker.address}", "-p", "mqtt_version:=5"
        )
    lines = assert_harmless(done.stdout.encode())
    assert any(rf"Not authorized (\x1b[2J\n{FORGED}\u202e)" in line for line in lines)


PROGRAM = r'''
import logging, sys
from rosbase import (BaseHandlers, BaseManager, BaseNode, register_multiprocess_nodes,
                     shutdown_multiprocess_nodes)

FORGED = "[INFO] [manager]: all is well"

class Failing(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.create_timer(0.01, self.fail)
    def fail(self):
        self.logger.warning(f"one\x1b[2J\n{FORGED}")
        try:
            raise OSError(f"two\n{FORGED}\x1b[2J")
        except OSError as error:
            self.logger.error("three", exc_info=error)
        logging.getLogger("rosbase.other").critical(f"four\n{FORGED}")
        raise ValueError(f"five\n{FORGED}\u202e")

CHILD = r"""printf '\033[2K\r%s\n' '[INFO] [manager]: all is well';
printf '\033]0;mine\007\033c\n\033[31mred\033[0m\n\302\205%s\n' '[INFO] [manager]: all is well';
printf '\342\200\256backwards'"""

class Handlers(BaseHandlers):
    def handle(self):
        if not any(child.is_alive for child in processes.values()):
            self.manager.request_stop()

if __name__ == "__main__":
    if "logging" in sys.argv:
        logging.basicConfig(format="[%(levelname)s] [%(name)s]: %(message)s", level="INFO")
    processes = register_multiprocess_nodes({"failing": Failing}, {"child": CHILD})
    manager = BaseManager("manager", handlers_class=Handlers, node_freq_hz=50)
    manager.start_main_loop_timer(processes)
    shutdown_multiprocess_nodes(processes)
'''


@pytest.mark.parametrize("logs", ["", "logging"])
def test_a_child_forges_no_line_and_touches_no_terminal(tmp_path: Path, logs: str) -> None:
    with running(tmp_path, PROGRAM, *([logs] if logs else [])) as program:
        status, out, err = program.end()
    assert (status, out) == (0, "")
    lines = assert_harmless(err.encode())
    forged = [line for line in lines if FORGED in line]
    # Whoever has said it is named in front of it; a traceback stands indented or has the name too.
    assert len(forged) >= 6
    # Before there is a manager, the children write for themselves.
    who = r"^\[[A-Z]+\] \[(rosbase\.)?(manager|processes)\]: "
    for line in forged:
        assert re.search(who + "(child|failing): ", line), line
    said = {re.sub(who, "", line) for line in lines}
    assert {
        "child: red",
        r"child: \x1b[2K",
        # A carriage return ends a line, and what follows has the name in front as well.
        f"child: {FORGED}",
        r"child: \x1b]0;mine\x07\x1bc",
        r"child: \u202ebackwards",
        rf"failing: one\x1b[2J\n{FORGED}",
        "failing: three",
        "failing: four",
    } <= said
