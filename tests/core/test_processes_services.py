"""Services between a manager and its children, and between children."""

from pathlib import Path

import pytest

from support.program import running

PROGRAM = """
import os, sys, threading, time
from attrs import frozen
from rosbase import (BaseHandlers, BaseManager, BaseNode, RestartPolicy, ServiceError,
                     register_multiprocess_nodes)

class Double:
    @frozen
    class Request:
        number: object = 0
    @frozen
    class Response:
        number: object = 0

def double(request):
    return Double.Response(2 * request.number)

class Server(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.create_service(Double, "~/double", self.answer)
    def answer(self, request):
        if request.number == "die":
            os.kill(os.getpid(), 9)
        if request.number == "raise":
            raise ValueError("no fingers")
        if request.number == "odd":
            return Double.Response(threading.Lock())
        if request.number == "sleep":
            time.sleep(0.5)
            return Double.Response(0)
        if request.number == "pid":
            return Double.Response(os.getpid())
        return double(request)

class Caller(BaseNode):
    # Answers by calling the service that it is asked for.
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.own = self.create_service(Double, "call", self.answer)
    def answer(self, request):
        client = self.create_client(Double, request.number)
        try:
            return Double.Response(client.call(Double.Request(21)).number)
        finally:
            self.destroy_client(client)

class Node(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.create_service(Double, "/here/double", double)
        self.arm = self.create_client(Double, "/arm/double")
        self.caller = self.create_client(Double, "/call")

class Handlers(BaseHandlers):
    def handle(self):
        node = self.node(Node)
        WHAT
        self.manager.request_stop()
    def attempt(self, what, timeout_s=5.0):
        before = time.monotonic()
        try:
            print(self.node(Node).arm.call(Double.Request(what), timeout_s=timeout_s).number)
        except ServiceError as error:
            print(type(error).__name__, str(error).replace(str(id), ""))
        assert time.monotonic() - before < timeout_s + 1.0

if __name__ == "__main__":
    processes = register_multiprocess_nodes(CHILDREN, {}, OPTIONS)
    manager = BaseManager(nodes_dict={"node": Node}, handlers_class=Handlers)
    manager.start_main_loop_timer(processes)
    print("ticks", manager.timestamp, "skipped", manager.loop_stats.overruns)
"""


def run(
    folder: Path, what: str, children: str = "{'arm': Server}", options: str = ""
) -> tuple[list[str], str]:
    """The lines that it prints, and its log."""
    indented = "\n        ".join(what.strip().splitlines())
    program = PROGRAM.replace("WHAT", indented).replace("CHILDREN", children)
    with running(folder, program.replace("OPTIONS", options)) as running_program:
        status, out, err = running_program.end()
        assert not running_program.family()
    assert status == 0, err
    return out.splitlines(), err


def test_a_thousand_calls_of_a_child_from_handle_are_all_answered(tmp_path: Path) -> None:
    what = """
if self.timestamp == 0:
    assert node.arm.wait_for_service(20.0)
for number in range(5):
    assert node.arm.call(Double.Request(number)).number == 2 * number
if self.timestamp < 199:
    return
print("dropped", node.arm.dropped)
"""
    (dropped, ticks), _ = run(tmp_path, what)
    assert dropped == "dropped 0"
    assert ticks.startswith("ticks 200 ")


def test_a_child_calls_its_manager_and_its_siblings(tmp_path: Path) -> None:
    what = """
for name in ("/here/double", "/arm/double"):
    print(node.caller.call(Double.Request(name), 20.0).number)
"""
    lines, _ = run(tmp_path, what, "{'arm': Server, 'caller': Caller}")
    assert lines[:2] == ["42", "42"]


@pytest.mark.parametrize(
    ("number", "text"),
    [
        ("'raise'", "ServiceFailedError /arm/double failed: ValueError: no fingers"),
        ("'odd'", "ServiceFailedError /arm/double failed: cannot send answer 2: TypeError"),
        (
            "threading.Lock()",
            "ServiceFailedError /arm/double failed: cannot send request /arm/double: TypeError",
        ),
        ("'die'", "ServiceFailedError /arm/double failed: it went away before it answered"),
    ],
)
def test_a_call_that_fails_in_a_child_is_an_error(tmp_path: Path, number: str, text: str) -> None:
    what = f"""
self.attempt(1, 20.0)
self.attempt({number})
"""
    lines, log = run(tmp_path, what)
    assert lines[0] == "2"
    assert lines[1].startswith(text)
    if "raise" in number:
        # The child's log has the rest.
        assert "[ERROR] [BaseManager]: arm: /arm/double failed: ValueError: no fingers" in log
        assert "Traceback" in log


def test_a_slow_child_is_an_error_in_time_and_its_late_answer_is_counted(tmp_path: Path) -> None:
    what = """
if self.timestamp == 0:
    self.attempt(1, 20.0)
    self.attempt("sleep", 0.1)
if not node.arm.dropped:
    return
print("dropped", node.arm.dropped)
"""
    lines, _ = run(tmp_path, what)
    assert lines[:3] == [
        "2",
        "ServiceTimeoutError /arm/double: no answer after 0.1 s",
        "dropped 1",
    ]


def test_a_child_that_is_started_again_answers_again(tmp_path: Path) -> None:
    what = """
first = node.arm.call(Double.Request("pid"), 20.0).number
self.attempt("die")
second = node.arm.call(Double.Request("pid"), 20.0).number
print(first != second)
"""
    options = "restart=RestartPolicy('on-failure', limit=3, first_delay_s=0.01)"
    lines, _ = run(tmp_path, what, options=options)
    assert lines[1] == "True"


def test_a_service_that_its_child_destroys_is_gone(tmp_path: Path) -> None:
    what = """
assert node.caller.wait_for_service(20.0)
print(node.caller.call(Double.Request("/here/double")).number)
print(node.caller.call(Double.Request("/here/destroy")).number)
while node.caller.service_is_ready():
    time.sleep(0.001)
"""
    # The child asks the manager for a service that asks the child to end its own.
    program = what.replace('"/here/destroy"', '"/call/destroy"')
    children = "{'caller': Destroying}"
    source = """
class Destroying(Caller):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.create_service(Double, "/call/destroy", self.end)
    def end(self, request):
        self.destroy_service(self.own)
        return Double.Response(7)

class Node("""
    with_class = PROGRAM.replace("\nclass Node(", source, 1)
    indented = "\n        ".join(program.strip().splitlines())
    text = with_class.replace("WHAT", indented).replace("CHILDREN", children)
    with running(tmp_path, text.replace("OPTIONS", "")) as running_program:
        status, out, err = running_program.end()
    assert status == 0, err
    assert out.splitlines()[:2] == ["42", "7"]
