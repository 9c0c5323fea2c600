"""The manager's loop with `timing="precise"` beside HORUS, whose core is in Rust, and a bare loop.

`nox -s bench` installs HORUS from the package index, runs this and prints a table. Each row is a
process of its own. The rows take turns; the medians of the turns count, and of ratios, those of
the turn's own.

- HORUS: `horus.run` with a node of that rate, as its documentation shows
- HORUS, same tick_rate: the same with the scheduler at the rate of the node, instead of 1 kHz
- manager, precise: `BaseManager(..., timing="precise")` on the backend `local`
- manager: the same with `timing="normal"`
- bare loop: sleep until the next deadline
"""

from functools import partial

from benchmarks.rig.loops import Turn, manager_row, measure, print_table, row_by_hand
from benchmarks.rig.turns import take_turns

ROWS = {
    "HORUS": row_by_hand("horus_loop.py"),
    "HORUS, same tick_rate": [*row_by_hand("horus_loop.py"), "same"],
    "manager, precise": manager_row("local", "precise"),
    "manager": manager_row("local", "normal"),
    "bare loop": row_by_hand("bare_loop.py"),
}
TURNS = 9
RATES_HZ = (200, 1000)


def turn(rate_hz: int, name: str) -> Turn:
    """One turn of a row."""
    return measure(ROWS[name], rate_hz)


def main() -> None:
    """Prints the tables."""
    for rate_hz in RATES_HZ:
        rows = take_turns(partial(turn, rate_hz), ROWS, TURNS)
        print_table(f"{rate_hz} Hz", rows, "HORUS")


if __name__ == "__main__":
    main()
