"""FANUC TP as ASCII: written and read."""
