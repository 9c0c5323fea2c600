"""The commands for running programs, as a table: their words, arguments and options.

Parsing, help, completion and the documentation's tests all read it. It needs no argparse, whose
import takes as long as half a start of Python.
"""

from rosbase.cli.operate.entries import Argument, Command, Group, Option

__all__ = ["GROUPS", "HELP", "PROGRAM", "all_options"]

PROGRAM = Option(
    "-P --program",
    "only this program: its name, or the number of its process",
    value="NAME|PID",
    completes="programs",
)
HELP = Option("-h --help", "show this help and end")
_JSON = Option("--json", "print JSON")
_TOPIC = Argument("topic", "name of the topic", completes="topics")
_NODE = Argument("node", "name of the node", completes="nodes")
_SERVICE = Argument("service", "name of the service", completes="services")
_PARAMETER = Argument("parameter", "name of the parameter", completes="parameters")
_LIFECYCLE_NODE = Argument("node", "name of the node", completes="lifecycle_nodes")
_HIDDEN = "list hidden ones too, such as /_private"
_TYPES = Option("-t --show-types", "print the types too")
_VALUES = "the values in YAML, such as '{x: 1.5}'; fields that are left out have their defaults"


def _window(default: int) -> Option:
    return Option(
        "-w --window",
        f"the number of messages to average over ({default})",
        value="N",
        kind="whole",
        default=default,
    )


_ECHO = Command(
    "print the messages of a topic",
    "observing.echo",
    _TOPIC,
    Argument("type", "its type, checked against the topic's", needed=False),
    Option("--field", "print only this field, such as pose.position or axes[0]", value="FIELD"),
    Option("--once", "print one message and end"),
    Option("--json", "print a line of JSON for each message"),
    Option("--csv", "print a line of values separated by commas for each message"),
    Option("--flow-style", "print YAML in one line"),
    Option("-f --full-length", "print long lists and texts in full"),
    Option(
        "-l --truncate-length",
        "the length from which lists and texts are cut (128; --json and --csv: not at all)",
        value="N",
        kind="count",
    ),
    Option("--no-arr", "leave out the elements of lists"),
    Option("--no-str", "leave out texts"),
    Option("--no-lost-messages", "do not report lost messages on stderr"),
    Option("--timeout", "end after this time, in seconds", value="S", kind="positive"),
)
_PUB = Command(
    "publish messages on a topic of a program",
    "publishing.publish",
    _TOPIC,
    Argument("type", "type of the message", completes="topic_type"),
    Argument("values", _VALUES, needed=False),
    Option(
        "-r --rate",
        "messages per second (1)",
        value="HZ",
        kind="positive",
        default=1.0,
    ),
    Option("-1 --once", "publish one message and end"),
    Option("-t --times", "publish so many messages and end", value="N", kind="whole"),
    Option(
        "-w --wait-matching-subscriptions",
        "wait for so many subscriptions first (1 with --once, otherwise 0)",
        value="N",
        kind="count",
    ),
    Option(
        "-p --print",
        "print every N-th message (1)",
        value="N",
        kind="count",
        default=1,
    ),
    Option(
        "--qos-reliability",
        "reliable or best_effort (reliable)",
        value="POLICY",
        completes="reliable best_effort",
    ),
    Option(
        "--qos-durability",
        "volatile or transient_local (volatile)",
        value="POLICY",
        completes="volatile transient_local",
    ),
    Option("--qos-depth", "the number of messages that are kept (10)", value="N", kind="whole"),
)

GROUPS: dict[str, Command | Group] = {
    "ps": Command(
        "list the running programs: state, rate, overruns, memory",
        "programs.show_processes",
        _JSON,
    ),
    "stats": Command(
        "print the tick times of a program",
        "statistics_text.show_statistics",
        Argument("program", "its name, or the number of its process", needed=False,
                 completes="programs"),
        _JSON,
    ),
    "stop": Command(
        "end a program, as with Ctrl-C",
        "programs.stop",
        Argument("name", "a program, the number of its process, or a program of `rosbase up`",
                 completes="stoppable"),
        Option(
            "--timeout",
            "how long to wait for the end, in seconds (10)",
            value="S",
            kind="positive",
            default=10.0,
        ),
    ),
    "restart": Command(
        "start a program of `rosbase up` anew",
        "programs.restart",
        Argument("name", "its name in the file of `rosbase up`", completes="launched"),
    ),
    "log": Command(
        "print the last records of the log of all programs",
        "log.show_log",
        Option("-f --follow", "go on with new records, until you stop the command"),
        Option(
            "-l --level",
            "records from this level on: debug, info, warn, error or fatal (debug)",
            value="LEVEL",
            default="debug",
            completes="debug info warn error fatal",
        ),
        Option("-n --lines", "print only the last N records", value="N", kind="count"),
    ),
    "node": Group(
        "list nodes, and what they publish and offer",
        {
            "list": Command(
                "list the nodes",
                "nodes.show_list",
                Option("-a --all", _HIDDEN),
                Option("-c --count-nodes", "print only how many there are"),
            ),
            "info": Command(
                "print the topics and services of a node", "nodes.show_info", _NODE
            ),
        },
    ),
    "topic": Group(
        "list, look at, measure and publish topics",
        {
            "list": Command(
                "list the topics",
                "topics.show_list",
                _TYPES,
                Option("-a --include-hidden-topics --all", _HIDDEN),
                Option("-c --count-topics", "print only how many there are"),
                Option("-v --verbose", "print the number of publishers and subscriptions"),
            ),
            "info": Command(
                "print the type and the ends of a topic",
                "topics.show_info",
                _TOPIC,
                Option("-v --verbose", "print each end with its quality of service"),
            ),
            "type": Command("print the type of a topic", "topics.show_type", _TOPIC),
            "find": Command(
                "list the topics of a type",
                "topics.find",
                Argument("type", "such as sensor_msgs/msg/Imu"),
                Option("-c --count-topics", "print only how many there are"),
            ),
            "echo": _ECHO,
            "hz": Command(
                "print the rate at which a topic is published", "observing.rate", _TOPIC,
                _window(10_000),
            ),
            "bw": Command(
                "print the bandwidth of a topic", "observing.bandwidth", _TOPIC, _window(100)
            ),
            "delay": Command(
                "print the age of messages, by the stamp of their header",
                "observing.delay",
                _TOPIC,
                _window(10_000),
            ),
            "pub": _PUB,
        },
    ),
    "service": Group(
        "list and call services",
        {
            "list": Command("list the services", "services.show_list", _TYPES,
                            Option("-a --include-hidden-services --all", _HIDDEN),
                            Option("-c --count-services", "print only how many there are")),
            "type": Command("print the type of a service", "services.show_type", _SERVICE),
            "call": Command(
                "call a service and print its response",
                "services.call",
                _SERVICE,
                Argument("type", "type of the service", completes="service_type", needed=False),
                Argument("values", _VALUES, needed=False),
                Option(
                    "--timeout",
                    "how long to wait for the response, in seconds (5)",
                    value="S",
                    kind="positive",
                    default=5.0,
                ),
            ),
        },
    ),
    "param": Group(
        "read, set, save and load parameters",
        {
            "list": Command(
                "list the parameters of all nodes, or of one",
                "parameters.show_list",
                Argument("node", "name of the node", completes="nodes", needed=False),
                Option("--param-type", "print the types too"),
            ),
            "get": Command(
                "print the value of a parameter",
                "parameters.show_value",
                _NODE,
                _PARAMETER,
                Option("--hide-type", "print only the value"),
            ),
            "set": Command(
                "set a parameter",
                "parameters.set_values",
                _NODE,
                Argument(
                    "name_and_value",
                    "name of the parameter and its value, in YAML; several pairs set several",
                    rest=True,
                    completes="parameters",
                ),
                Option("--atomic", "set all of them or none"),
            ),
            "describe": Command(
                "print what parameters mean and which values they take",
                "parameters.describe",
                _NODE,
                Argument("parameters", "their names", rest=True, completes="parameters"),
            ),
            "dump": Command(
                "print all parameters of a node as a parameter file", "parameters.dump", _NODE
            ),
            "load": Command(
                "set the parameters in a file",
                "parameters.load",
                _NODE,
                Argument("file", "a parameter file: YAML of ROS 2, or TOML", completes="files"),
                Option("--no-use-wildcard", "leave out the parameters for every node (/**)"),
            ),
        },
    ),
    "lifecycle": Group(
        "look at lifecycle nodes, and change their states",
        {
            "nodes": Command(
                "list the lifecycle nodes",
                "lifecycle.show_nodes",
                Option("-c --count-nodes", "print only how many there are"),
            ),
            "list": Command(
                "list the transitions that a node offers now", "lifecycle.show_transitions",
                _LIFECYCLE_NODE,
            ),
            "get": Command(
                "print the state of a node, or of all",
                "lifecycle.show_state",
                Argument("node", "name of the node", completes="lifecycle_nodes", needed=False),
            ),
            "set": Command(
                "run a transition",
                "lifecycle.change_state",
                _LIFECYCLE_NODE,
                Argument("transition", "its label or id", completes="transitions"),
            ),
        },
    ),
    "completion": Command(
        "print a script that completes commands in a shell",
        "completion.show_script",
        Argument("shell", "bash, zsh or fish", completes="bash zsh fish"),
    ),
}  # fmt: skip
"""The commands by their first word."""

_WITHOUT_PROGRAM = ("completion.show_script", "programs.stop", "programs.restart",
                    "statistics_text.show_statistics")  # fmt: skip


def all_options(command: Command) -> tuple[Option, ...]:
    """Return the options of a command, and those that all commands have."""
    everywhere = (HELP,) if command.does in _WITHOUT_PROGRAM else (PROGRAM, HELP)
    return (*command.options, *everywhere)
