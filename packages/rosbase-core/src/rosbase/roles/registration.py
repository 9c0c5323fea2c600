"""How a manager registers its components, one after the other: each takes its key."""

from attrs import define, field

__all__ = ["Registration"]


@define
class Registration:
    """State of a registration, which a component reads while it is built."""

    node_name: str
    """Name that the program gives the manager."""
    has_custom_logger: bool
    """Whether the manager's logger is of a class of the application."""
    _key: str = field(init=False, default="")
    _kind: type = field(init=False, default=object)

    def begin(self, key: str, component: object) -> None:
        """Prepare for a component: its key in `nodes` or `agents`, and its class or a factory."""
        self._key = key
        self._kind = component if isinstance(component, type) else object

    def end(self) -> None:
        """Note that the component is built."""
        self._key = ""

    def take_key(self, component: object) -> str:
        """Return the key if it is for this component: helpers that it builds have none."""
        if not isinstance(component, self._kind):
            return ""
        key, self._key = self._key, ""
        return key
