"""Text from outside, such as a topic or an error, made safe for a terminal or a log."""
