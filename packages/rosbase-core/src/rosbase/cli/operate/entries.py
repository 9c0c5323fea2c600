"""Parts of the table of commands: options, arguments, commands and groups of them."""

__all__ = ["Argument", "Command", "Group", "Option"]


class Option:
    """An option of a command."""

    __slots__ = ("completes", "default", "flags", "help", "kind", "many", "value")

    def __init__(
        self,
        flags: str,
        help_text: str,
        *,
        value: str = "",
        kind: str = "text",
        default: object = None,
        many: bool = False,
        completes: str = "",
    ) -> None:
        self.flags = tuple(flags.split())
        """How it can be written, the long form last."""
        self.help = help_text
        self.value = value
        """Name of its value in the help; empty for a switch."""
        self.kind = kind
        """Kind of its value: text, positive (number), whole (number) or count (0 or more)."""
        self.default = default if value or default is not None else False
        self.many = many
        """Whether it can be given several times, so that its value is a list."""
        self.completes = completes
        """Candidates that a shell offers for its value: a kind of live name, or words."""

    @property
    def key(self) -> str:
        """The name under which commands find its value."""
        return self.flags[-1].lstrip("-").replace("-", "_")


class Argument:
    """An argument of a command."""

    __slots__ = ("completes", "help", "key", "needed", "rest")

    def __init__(
        self,
        name: str,
        help_text: str,
        *,
        completes: str = "",
        needed: bool = True,
        rest: bool = False,
    ) -> None:
        self.key = name
        self.help = help_text
        self.completes = completes
        self.needed = needed
        self.rest = rest
        """Whether it takes all arguments that are left."""

    @property
    def shown(self) -> str:
        """How it stands in the usage."""
        name = self.key.upper() + ("..." if self.rest else "")
        return name if self.needed else f"[{name}]"


class Command:
    """A command: what it takes, and the module with the function that runs it."""

    __slots__ = ("arguments", "does", "options", "summary")

    def __init__(self, summary: str, does: str, *takes: "Argument | Option") -> None:
        self.summary = summary
        self.does = does
        """Module and function, as `topics.show_list`, below `rosbase.cli.operate`."""
        self.arguments = tuple(item for item in takes if isinstance(item, Argument))
        self.options = tuple(item for item in takes if isinstance(item, Option))


class Group:
    """A first word with commands as its second words."""

    __slots__ = ("commands", "summary")

    def __init__(self, summary: str, commands: dict[str, Command]) -> None:
        self.summary = summary
        self.commands = commands
