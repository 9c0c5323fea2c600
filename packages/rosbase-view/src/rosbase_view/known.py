"""All that the view knows of the programs: the sum of all reports."""

from collections import deque
from collections.abc import Iterable, Sequence

from rosbase.control.shapes import LogRecord, Process, Statistics
from rosbase_view.owners import owners
from rosbase_view.reports import (
    Counted,
    Heard,
    Logged,
    NodeKey,
    NodeReport,
    NodeRow,
    Position,
    Report,
    Said,
    Survey,
    TopicKey,
)
from rosbase_view.source import Gaze
from rosbase_view.topic_state import TopicState

__all__ = ["MOST_RECORDS", "Known"]

MOST_RECORDS = 1_000
_SAID_NS = 10_000_000_000


class Known:
    """The state of everything that is shown. Takes reports; knows no source and no terminal."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self.has_survey = False
        """Whether any source has told what runs."""
        self.processes: Sequence[Process] = ()
        self.silent: frozenset[int] = frozenset()
        """Pids of processes that do not answer."""
        self.topics: dict[TopicKey, TopicState] = {}
        self.owners: dict[TopicKey, str] = {}
        """Program of each topic whose name other topics have too."""
        self.nodes: dict[NodeKey, NodeRow] = {}
        self.loops: Sequence[Statistics] = ()
        self.cpu: dict[int, float] = {}
        """Share of a processor that each process used between the last two surveys."""
        self.log: deque[LogRecord] = deque(maxlen=MOST_RECORDS)
        self.logged = 0
        """Records so far, also those that have left `log`."""
        self.heard: dict[TopicKey, Heard] = {}
        """Last message of each topic that is looked at."""
        self.node_reports: dict[NodeKey, NodeReport] = {}
        """Report on each node that is looked at."""
        self.position: Position | None = None
        """Where a recording is; None for what runs."""
        self._trouble: Said | None = None
        self._said: Said | None = None
        self._said_ns = 0
        self._survey_ns = 0

    def take(self, reports: Iterable[Report], now_ns: int) -> None:
        """Take reports, at a monotonic time."""
        reports = list(reports)
        for report in reports:
            if isinstance(report, Position):
                self.move(report)
        time_ns = self.time_ns(now_ns)
        for report in reports:
            if isinstance(report, Counted):
                if (topic := self.topics.get(report.topic)) is not None:
                    if report.is_first:
                        topic.restart()
                    last_ns = time_ns - int(report.age_s * 1e9)
                    topic.count(report.count, report.seconds, last_ns, time_ns)
            elif isinstance(report, Survey):
                self._learn(report, now_ns)
            elif isinstance(report, Heard):
                self.heard[report.topic] = report
            elif isinstance(report, Logged):
                if report.is_first:
                    self.log.clear()
                self.log.extend(report.records)
                self.logged += len(report.records)
            elif isinstance(report, NodeReport):
                self.node_reports[report.node] = report
            elif isinstance(report, Said):
                self._said, self._said_ns = report, now_ns

    @property
    def programs(self) -> dict[int, str]:
        """Return the name of the program of each process."""
        return {process["pid"]: process["name"] for process in self.processes}

    def time_ns(self, now_ns: int) -> int:
        """Return the time of the topics: the recording's, or the monotonic one."""
        return now_ns if self.position is None else self.position.now_ns

    def move(self, position: Position, *, is_jump: bool = False) -> None:
        """Take the position of a recording; what was counted before a jump counts no more."""
        if is_jump or (self.position is not None and position.now_ns < self.position.now_ns):
            for topic in self.topics.values():
                topic.restart()
        self.position = position

    def forget_unseen(self, gaze: Gaze) -> None:
        """Forget the messages of topics that nobody looks at, because they would grow old."""
        self.heard = {key: one for key, one in self.heard.items() if key in gaze.topics}

    def said(self, now_ns: int) -> Said | None:
        """Return what the user should read now.

        After ten seconds it is gone. Trouble with a program is gone when the program is back.
        """
        if self._said is not None and now_ns - self._said_ns > _SAID_NS:
            self._said = None
        return self._said or self._trouble

    def _learn(self, survey: Survey, now_ns: int) -> None:
        self._learn_cpu(survey.processes, now_ns)
        self.has_survey = True
        self.processes, self.loops = survey.processes, survey.loops
        self.silent = survey.silent
        self._trouble = Said(survey.trouble, is_error=True) if survey.trouble else None
        for key, topic in survey.topics.items():
            if key in self.topics:
                self.topics[key].learn(topic)
            else:
                self.topics[key] = TopicState(topic)
        self.topics = {key: self.topics[key] for key in sorted(survey.topics)}
        self.owners = owners(self.topics, self.programs)
        self.nodes = {node.key: node for node in survey.nodes}
        self.heard = {key: one for key, one in self.heard.items() if key in self.topics}
        self.node_reports = {
            key: one for key, one in self.node_reports.items() if key in self.nodes
        }

    def _learn_cpu(self, processes: Sequence[Process], now_ns: int) -> None:
        before = {process["pid"]: process["cpu_ns"] for process in self.processes}
        passed_ns = now_ns - self._survey_ns
        self._survey_ns = now_ns
        self.cpu = {
            process["pid"]: max(0, process["cpu_ns"] - before[process["pid"]]) / passed_ns
            for process in processes
            if process["pid"] in before and passed_ns > 0
        }
