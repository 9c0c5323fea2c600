"""Child processes of a manager: nodes and shell commands that end when it ends."""

from rosbase.processes.child import ChildProcess
from rosbase.processes.registration import (
    ChildProcesses,
    register_multiprocess_nodes,
    shutdown_multiprocess_nodes,
    shutdown_unclaimed,
)
from rosbase.processes.restart import RestartPolicy

__all__ = [
    "ChildProcess",
    "ChildProcesses",
    "RestartPolicy",
    "register_multiprocess_nodes",
    "shutdown_multiprocess_nodes",
    "shutdown_unclaimed",
]
