"""Pairs of points to a place: the fits, their proofs, and what the pairs themselves give away."""
