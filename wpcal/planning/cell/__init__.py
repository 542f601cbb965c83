"""The cell: what stands where, its bodies and their distances, and the closed chain of both arms."""
