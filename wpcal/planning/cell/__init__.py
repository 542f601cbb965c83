"""The cell: arms, bases and bodies, the distances between bodies, and the closed chain of both arms."""
