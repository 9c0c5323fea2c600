"""The source of running programs: attached to their control sockets."""
