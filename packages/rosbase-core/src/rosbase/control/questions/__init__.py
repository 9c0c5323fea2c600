"""Questions to running programs, by subject.

A command imports only its own subject, because each import counts in its short life.
"""
