"""Plans: states and times, the check for collisions, and the files of a run."""
