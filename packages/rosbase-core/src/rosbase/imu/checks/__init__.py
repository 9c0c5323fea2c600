"""Checks of what is known: each compares samples with a fact, and says what contradicts it."""
