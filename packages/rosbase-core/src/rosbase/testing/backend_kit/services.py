"""Checks of services: calls and answers, and the errors of calls without one."""

from rosbase.testing.backend_kit.service_calls import ServiceCallChecks
from rosbase.testing.backend_kit.service_ends import ServiceEndChecks

__all__ = ["ServiceChecks"]


class ServiceChecks(ServiceCallChecks, ServiceEndChecks):
    """Checks that every call ends, with its answer or with an error in time."""
