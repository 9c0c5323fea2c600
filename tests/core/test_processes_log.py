"""What a node logs in a process of its own, whatever libraries do there."""

from pathlib import Path

import pytest

from support.program import running

APP = """
import logging
import logging.config
from rosbase import BaseHandlers, BaseManager, BaseNode, register_multiprocess_nodes

class Node(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        LIBRARY
        self.logger.debug("looking")
        self.logger.info("bent by %d", 30)
        self.logger.warn("hot", once=True)
        self.logger.get_child("knee").error("lost")
        try:
            raise OSError("gone")
        except OSError:
            self.logger.exception("broken")
        self.request_stop()

class Handlers(BaseHandlers):
    def handle(self):
        if not processes["x"].is_alive:
            self.manager.request_stop()

if __name__ == "__main__":
    processes = register_multiprocess_nodes({"x": Node}, {})
    manager = BaseManager(handlers_class=Handlers)
    manager.start_main_loop_timer(processes)
"""


@pytest.mark.parametrize(
    "library",
    [
        "pass",
        "logging.info('lib')",
        "logging.basicConfig(level='CRITICAL', format='%(message)s')",
        "logging.config.dictConfig({'version': 1})",
        "logging.getLogger().addHandler(logging.NullHandler())",
    ],
)
def test_each_record_of_a_child_is_in_the_log_once_with_its_level(
    tmp_path: Path, library: str
) -> None:
    with running(tmp_path, APP.replace("LIBRARY", library)) as program:
        status, out, err = program.end()
    assert (status, out) == (0, "")
    lines = [line.replace("[processes]", "[BaseManager]") for line in err.splitlines()]
    said = [line for line in lines if "Traceback" not in line and "File" not in line]
    assert said[:4] == [
        "[INFO] [BaseManager]: x: bent by 30",
        "[WARN] [BaseManager]: x: hot",
        "[ERROR] [BaseManager]: x: lost",
        "[ERROR] [BaseManager]: x: broken",
    ]
    traceback = lines[lines.index("[ERROR] [BaseManager]: x: broken") + 1 :]
    assert traceback[0] == "[ERROR] [BaseManager]: x:   Traceback (most recent call last):"
    end = "[ERROR] [BaseManager]: x:   OSError: gone"
    assert all(line.startswith("[ERROR] ") for line in traceback[: traceback.index(end)])
    assert err.count("bent by") == 1


EARLY = """
from rosbase import register_multiprocess_nodes, shutdown_multiprocess_nodes
if __name__ == "__main__":
    processes = register_multiprocess_nodes({}, {"x": "echo early; exit 3"})
    while processes["x"].exit_code is None:
        pass
    shutdown_multiprocess_nodes(processes)
"""


def test_the_level_of_the_environment_counts_before_there_is_a_manager(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROSBASE_LOG_LEVEL", "error")
    with running(tmp_path, EARLY) as program:
        status, _, err = program.end()
    assert (status, err) == (0, "[ERROR] [processes]: x: ended with status 3\n")
