"""A plan: its states and times, the check of its clearances, and its files."""
