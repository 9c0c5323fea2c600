"""Where records go: real programs, with what libraries and applications do to `logging`."""

import subprocess
import sys
from pathlib import Path

import pytest

from rosbase import BaseManager
from rosbase.testing import virtual_backend
from support.log_lines import without_times

PROGRAM = """
import sys
{before}
from rosbase import BaseManager, BaseNode
manager = BaseManager("boss", {{"camera": BaseNode}})
logger = manager.nodes["camera"].logger
{after}
logger.debug("looking")
logger.info("ready")
logger.warning("hot")
manager.destroy_node()
"""

OURS = "[INFO] [boss.camera]: ready\n[WARN] [boss.camera]: hot\n"
THEIRS = "INFO:rosbase.boss.camera:ready\nWARNING:rosbase.boss.camera:hot\n"

FILE_CONFIG = """
import io, logging.config
logging.config.fileConfig(io.StringIO('''
[loggers]
keys = root
[handlers]
keys = console
[formatters]
keys = short
[logger_root]
level = INFO
handlers = console
[handler_console]
class = StreamHandler
args = (sys.stderr,)
formatter = short
[formatter_short]
format = %(name)s %(message)s
'''))
"""

ROOT_DICT = """
import logging.config
logging.config.dictConfig({
    "version": 1,
    "formatters": {"short": {"format": "%(name)s %(message)s"}},
    "handlers": {"console": {"class": "logging.StreamHandler", "formatter": "short"}},
    "root": {"handlers": ["console"], "level": "LEVEL"},
})
"""


def run(before: str = "", after: str = "", *options: str) -> tuple[str, str]:
    """What the program writes to stdout and to stderr."""
    done = subprocess.run(
        [sys.executable, "-W", "error", *options, "-c", PROGRAM.format(before=before, after=after)],
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout, without_times(done.stderr)


LIBRARIES = {
    "nothing": ("", ""),
    "logging.info": ("import logging; logging.info('lib')", ""),
    "logging.warning": ("import logging; logging.warning('lib')", "WARNING:root:lib\n"),
    "a bare basicConfig": ("import logging; logging.basicConfig()", ""),
    "basicConfig at WARNING": ("import logging; logging.basicConfig(level='WARNING')", ""),
    "a handler that writes nothing": (
        "import logging; logging.getLogger().addHandler(logging.NullHandler())",
        "",
    ),
    "that, and logging.error": (
        "import logging; logging.getLogger().addHandler(logging.NullHandler());"
        " logging.getLogger('lib').error('lib')",
        "",
    ),
    "the root's level": ("import logging; logging.getLogger().setLevel('CRITICAL')", ""),
    "no last resort": ("import logging; logging.lastResort = None", ""),
    "a logger of its own": (
        "import logging; lib = logging.getLogger('lib'); lib.setLevel('ERROR');"
        " lib.addHandler(logging.StreamHandler()); lib.error('lib')",
        "lib\n",
    ),
    "a dictConfig that disables what there is": (
        "import logging.config; logging.config.dictConfig({'version': 1})",
        "",
    ),
    "captured warnings": ("import logging; logging.captureWarnings(True)", ""),
    "a logger class of its own": (
        "import logging; logging.setLoggerClass(type('Log', (logging.Logger,), {}))",
        "",
    ),
}


@pytest.mark.parametrize("when", ["before", "after"])
@pytest.mark.parametrize("library", LIBRARIES)
def test_whatever_a_library_does_the_lines_of_the_roles_are_seen_once(
    library: str, when: str
) -> None:
    code, said = LIBRARIES[library]
    assert run(**{when: code}) == ("", said + OURS)


@pytest.mark.parametrize("when", ["before", "after"])
@pytest.mark.parametrize("level", ["INFO", "DEBUG", "NOTSET"])
def test_a_library_that_asks_for_more_gets_the_lines_once_in_its_format(
    level: str, when: str
) -> None:
    code = f"import logging; logging.basicConfig(level='{level}')"
    looking = "" if level == "INFO" else "DEBUG:rosbase.boss.camera:looking\n"
    assert run(**{when: code}) == ("", looking + THEIRS)


APPLICATIONS = {
    "basicConfig with a format": (
        "import logging; logging.basicConfig(format='%(message)s')",
        ("", "hot\n"),
    ),
    "basicConfig with a format and a level": (
        "import logging; logging.basicConfig(format='%(message)s', level='INFO')",
        ("", "ready\nhot\n"),
    ),
    "basicConfig for another stream": (
        "import logging; logging.basicConfig(stream=sys.stdout)",
        ("WARNING:rosbase.boss.camera:hot\n", ""),
    ),
    "basicConfig after a library spoke": (
        "import logging; logging.info('lib');"
        " logging.basicConfig(format='%(message)s', level='INFO', force=True)",
        ("", "ready\nhot\n"),
    ),
    "a level for the root after a library spoke": (
        "import logging; logging.info('lib'); logging.getLogger().setLevel('INFO')",
        ("", THEIRS),
    ),
    "dictConfig at INFO": (
        ROOT_DICT.replace("LEVEL", "INFO"),
        ("", "rosbase.boss.camera ready\nrosbase.boss.camera hot\n"),
    ),
    "dictConfig at WARNING": (
        ROOT_DICT.replace("LEVEL", "WARNING"),
        ("", "rosbase.boss.camera hot\n"),
    ),
    "fileConfig": (FILE_CONFIG, ("", "rosbase.boss.camera ready\nrosbase.boss.camera hot\n")),
    "a handler of rosbase's logger": (
        "import logging; ours = logging.getLogger('rosbase'); ours.setLevel('DEBUG');"
        " ours.addHandler(logging.StreamHandler(sys.stdout))",
        ("looking\nready\nhot\n", ""),
    ),
    "a handler of rosbase's logger, and a library that spoke": (
        "import logging; logging.info('lib'); ours = logging.getLogger('rosbase');"
        " ours.setLevel('INFO'); ours.addHandler(logging.StreamHandler(sys.stdout));"
        " ours.propagate = False",
        ("ready\nhot\n", ""),
    ),
    "silence": (
        "import logging; logging.getLogger('rosbase').addHandler(logging.NullHandler())",
        ("", ""),
    ),
    "a level of rosbase's logger": (
        "import logging; logging.getLogger('rosbase').setLevel('WARNING')",
        ("", "[WARN] [boss.camera]: hot\n"),
    ),
    "a lower level of rosbase's logger": (
        "import logging; logging.info('lib'); logging.getLogger('rosbase').setLevel('DEBUG')",
        ("", "[DEBUG] [boss.camera]: looking\n" + OURS),
    ),
    "a level of one logger": (
        "import logging; logging.getLogger('rosbase.boss.camera').setLevel('ERROR')",
        ("", ""),
    ),
    "logging.disable": (
        "import logging; logging.disable(logging.INFO)",
        ("", "[WARN] [boss.camera]: hot\n"),
    ),
}


@pytest.mark.parametrize("when", ["before", "after"])
@pytest.mark.parametrize("application", APPLICATIONS)
def test_an_application_that_sets_up_logging_keeps_its_control(application: str, when: str) -> None:
    code, said = APPLICATIONS[application]
    assert run(**{when: code}) == said


def test_a_file_of_the_application_gets_the_lines_and_the_console_none(tmp_path: Path) -> None:
    file = tmp_path / "app.log"
    code = f"import logging; logging.basicConfig(filename={str(file)!r}, level='INFO')"
    assert run(code) == ("", "")
    assert file.read_text() == THEIRS


def test_a_handler_that_an_application_adds_later_takes_over() -> None:
    after = (
        "logger.info('first'); import logging;"
        " logging.basicConfig(format='app: %(message)s', level='INFO')"
    )
    assert run(after=after) == ("", "[INFO] [boss.camera]: first\napp: ready\napp: hot\n")


def test_caplog_has_the_lines_and_the_console_none(
    caplog: pytest.LogCaptureFixture, capsys: pytest.CaptureFixture[str]
) -> None:
    caplog.set_level("INFO")
    manager = BaseManager("boss", backend=virtual_backend())
    manager.logger.info("ready")
    manager.destroy_node()
    assert "ready" in caplog.messages
    assert capsys.readouterr() == ("", "")
