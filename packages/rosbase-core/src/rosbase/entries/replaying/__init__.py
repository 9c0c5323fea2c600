"""Replaying: one thread runs the entries of a script, without locks and without waiting.

`player` is the conductor of a replay. It is strict until the program does something else than it
did when it was recorded: `flow` says what. From there on it is free: `inputs` come at their
recorded times, and timers and ticks in virtual time. `registry` knows the objects that entries
name by a number, `posted` the calls of threads of the user, and `pace` slows a replay down.
"""
