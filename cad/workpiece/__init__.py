"""A workpiece: a part as read, what is on it, and the main job as one function."""
