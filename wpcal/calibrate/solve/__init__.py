"""From observations to a pose: minimax with its proof, least squares, weighted fits, ties, and bodies that moved."""
