"""Entries: the order in which a program ran, recorded so that it can run the same way again.

While a program is recorded, one thread at a time runs it: the one that holds the turn. Whatever
that thread runs as a whole is an entry: a tick, a timer, a queued call, a frame, a message from
outside. Entries are numbered from 0, which is the construction of the program.

`turn` says who runs the program. `kinds` are the kinds of entries, `trace` is where they are noted,
`payloads` is the content of the ones that come from outside, and `script` reads them back.
`conductor` is the interface that all seams of rosbase use, and `sink` the one of a file.
"""
