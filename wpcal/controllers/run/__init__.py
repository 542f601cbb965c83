"""Execution of finished programs: an interpreter for each language, and the machines that it moves."""
