"""Nodes in processes of their own: what they are made with, say, publish and log."""

from pathlib import Path

import pytest

from support.program import running

PROGRAM = """
import logging, os, sys
from rosbase import (BaseHandlers, BaseManager, BaseNode, RestartPolicy,
                     register_multiprocess_nodes, shutdown_multiprocess_nodes)
from rosbase.messages import Header
from rosbase.qos import DurabilityPolicy, QoSProfile

LATCHED = QoSProfile(1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

class Child(BaseNode):
    def __init__(self, manager=None, *args, **kwargs):
        super().__init__(manager, *args, **kwargs)
        self.say = self.create_publisher(Header, "~/answer", 10)
        self.given = f"{manager} {args} {kwargs} {self.logger.name} {os.getpid()}"
        self.create_subscription(Header, "question", self.answer, 10)
    def answer(self, message):
        self.say.publish(Header(frame_id=self.given))

class Relay(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.say = self.create_publisher(Header, "relayed", 10)
        self.create_subscription(Header, "/eye/answer", self.say.publish, 10)

class Talker(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.create_timer(0.01, self.talk)
        self.has_talked = False
    def talk(self):
        if not self.has_talked:
            self.has_talked = True
            self.logger.debug("too much")
            self.logger.info("fine")
            self.logger.warning("hm")
            self.logger.error("bad")
            logging.getLogger("rosbase.other").critical("worse")

class Failing(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.create_timer(0.01, self.fail)
    def fail(self):
        raise ValueError("lens cap is on")

class Reader(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.say = self.create_publisher(Header, "read", LATCHED)
        self.create_subscription(Header, "map", self.read, LATCHED)
    def read(self, message):
        self.say.publish(Header(frame_id=f"{message.frame_id} {os.getpid()}"))
        raise ValueError("read and gone")

class Parent(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.got = {}
        ask = self.create_publisher(Header, "question", 10)
        self.create_timer(0.01, lambda: ask.publish(Header()))
        for topic in ("/eye/answer", "/ear/answer", "relayed"):
            self.create_subscription(Header, topic, lambda m, t=topic: self.keep(t, m), 10)
    def keep(self, topic, message):
        self.got[topic] = message.frame_id

class Log(logging.Handler):
    said = []
    def emit(self, record):
        self.said.append((record.levelname, record.name, record.getMessage()))

class Handlers(BaseHandlers):
    def handle(self):
        if self.manager.is_done():
            self.manager.request_stop()

if __name__ == "__main__":
    logging.getLogger("rosbase").addHandler(Log())
    logging.getLogger("rosbase").setLevel("INFO")
    BODY
"""


def run(folder: Path, body: str) -> list[str]:
    """What the program prints; it must end well."""
    with running(folder, PROGRAM.replace("BODY", body.strip().replace("\n", "\n    "))) as program:
        status, out, err = program.end()
        assert (status, err) == (0, "")
        assert not program.family()
    return out.splitlines()


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str]]:
    """What a parent got from its children, by topic: word by word."""
    body = """
processes = register_multiprocess_nodes({"eye": Child, "ear": Child, "relay": Relay}, {})
class App(BaseManager):
    def is_done(self):
        return len(self.nodes["parent"].got) == 3
app = App("boss", {"parent": Parent}, None, Handlers, speed=0.5)
app.start_main_loop_timer(processes)
print(os.getpid())
for topic, text in app.nodes["parent"].got.items():
    print(topic, text)
"""
    own, *lines = run(tmp_path_factory.mktemp("answers"), body)
    return {topic: words for topic, *words in map(str.split, lines)} | {"parent": [own]}


def test_topics_go_from_the_parent_to_a_child_and_back(answers: dict[str, list[str]]) -> None:
    assert answers["/eye/answer"]
    assert answers["/ear/answer"]


def test_topics_go_from_one_child_of_a_manager_to_another(answers: dict[str, list[str]]) -> None:
    assert answers["relayed"] == answers["/eye/answer"]


def test_each_node_runs_in_a_python_process_of_its_own(answers: dict[str, list[str]]) -> None:
    pids = [answers["/eye/answer"][-1], answers["/ear/answer"][-1], *answers["parent"]]
    assert len(set(pids)) == 3


def test_a_node_in_a_child_gets_no_arguments_and_its_name_from_the_key(
    answers: dict[str, list[str]],
) -> None:
    assert answers["/eye/answer"][:-1] == ["None", "()", "{}", "eye"]
    assert answers["/ear/answer"][:-1] == ["None", "()", "{}", "ear"]


def test_what_a_node_in_a_child_logs_is_in_the_managers_log_at_its_level(tmp_path: Path) -> None:
    body = """
processes = register_multiprocess_nodes({"talker": Talker}, {})
class App(BaseManager):
    def is_done(self):
        return any("worse" in text for _, _, text in Log.said)
App("boss", {}, None, Handlers).start_main_loop_timer(processes)
for level, _, text in Log.said:
    print(level, text)
"""
    assert run(tmp_path, body)[:4] == [
        "INFO talker: fine",
        "WARNING talker: hm",
        "ERROR talker: bad",
        "CRITICAL talker: worse",
    ]


def test_the_traceback_of_a_node_that_fails_in_a_child_is_in_the_managers_log(
    tmp_path: Path,
) -> None:
    body = """
processes = register_multiprocess_nodes({"eye": Failing}, {})
class App(BaseManager):
    def is_done(self):
        return any("ended with" in text for _, _, text in Log.said)
App("boss", {}, None, Handlers).start_main_loop_timer(processes)
print(*[text for _, _, text in Log.said], sep="\\n")
"""
    lines = run(tmp_path, body)
    assert "eye: Traceback (most recent call last):" in lines
    assert "eye: ValueError: lens cap is on" in lines
    assert any('raise ValueError("lens cap is on")' in line for line in lines)
    assert "eye: ended with status 1" in lines


def test_a_command_that_fails_does_not_stop_the_manager(tmp_path: Path) -> None:
    body = """
processes = register_multiprocess_nodes({}, {"port": "exit 3"})
class App(BaseManager):
    ticks_after = 0
    def is_done(self):
        self.ticks_after += processes["port"].exit_code == 3
        return self.ticks_after == 10
App("boss", {}, None, Handlers).start_main_loop_timer(processes)
print(processes["port"].exit_code)
"""
    assert run(tmp_path, body) == ["3"]


def test_a_child_that_is_started_again_gets_what_was_kept_for_it(tmp_path: Path) -> None:
    body = """
class Mapper(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.read = []
        self.create_publisher(Header, "map", LATCHED).publish(Header(frame_id="hall"))
        self.create_subscription(Header, "read", lambda m: self.read.append(m.frame_id), LATCHED)
class App(BaseManager):
    def is_done(self):
        return len(self.nodes["mapper"].read) == 2
policy = RestartPolicy("always", first_delay_s=0)
processes = register_multiprocess_nodes({"reader": Reader}, {}, restart=policy)
app = App("boss", {"mapper": Mapper}, None, Handlers)
app.start_main_loop_timer(processes)
print(*app.nodes["mapper"].read, sep="\\n")
"""
    first, second = map(str.split, run(tmp_path, body))
    assert first[0] == second[0] == "hall"
    assert first[1] != second[1]
