"""The standard services of ROS nodes on the local backend: lifecycle and parameters.

They cost next to nothing until the first request. Until then, a node is one entry in the
registry of services, and no message class is imported.
"""
