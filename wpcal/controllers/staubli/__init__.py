"""Stäubli VAL 3: written."""
