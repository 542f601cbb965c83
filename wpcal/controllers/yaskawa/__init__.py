"""Yaskawa INFORM: written, read, and for two robots in step."""
