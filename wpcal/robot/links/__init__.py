"""The robot's own position, read over its network: one module per kind of controller, and one judge of what is read.

Read only by construction: no message that could move the robot or write to its controller is implemented.
"""
