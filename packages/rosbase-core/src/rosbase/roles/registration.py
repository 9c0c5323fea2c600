"""How a manager registers its components, one after the other: each takes its key."""

from attrs import define

__all__ = ["Registration"]


@define
class Registration:
    """State of a registration, which a component reads while it is built."""

    node_name: str
    """Name that the program gives the manager."""
    has_custom_logger: bool
    """Whether the manager's logger is of a class of the application."""
    key: str = ""
    """Key of the component that is built next, in `nodes` or `agents`; or empty."""

    def take_key(self) -> str:
        """Return the key for the component that asks first: others in its constructor have none."""
        key, self.key = self.key, ""
        return key
