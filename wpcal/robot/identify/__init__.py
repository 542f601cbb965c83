"""Identification: measured poses to the parameters of an arm, and which poses to measure."""
