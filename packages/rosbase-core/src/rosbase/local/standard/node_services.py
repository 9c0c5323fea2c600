"""The standard services of one node, made when the first request comes."""

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from rosbase.contracts.service_callback import service_answer
from rosbase.contracts.service_server import ServiceServer
from rosbase.logger import RosbaseLogger
from rosbase.runtime.executor import Executor

__all__ = ["Answers", "make_services"]

Answers: TypeAlias = Mapping[str, tuple[Any, Callable[[Any], Any]]]
"""By the name of a service, its type and the function that answers its requests."""


def make_services(
    node: str, answers: Answers, executor: Executor, logger: RosbaseLogger
) -> dict[str, ServiceServer]:
    """Return the services of a node by their names in the catalog.

    Args:
        node: Full name of the node.
        answers: How it answers.
        executor: The executor of the backend, on whose thread the answers are made.
        logger: Logs answers that fail.
    """
    made = {}
    for service, (kind, callback) in answers.items():
        name = f"{node}/{service}"
        made[service] = ServiceServer(name, service_answer(kind, name, callback), executor, logger)
    return made
