"""The roles: node, lifecycle node, agent and handlers, and what connects them."""
