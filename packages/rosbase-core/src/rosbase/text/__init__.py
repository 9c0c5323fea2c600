"""Text from outside, such as a topic or an error: what of it may reach a terminal or a log."""
