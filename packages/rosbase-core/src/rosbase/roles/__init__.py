"""The roles: node, lifecycle node, agent and handlers, and their connections."""
