"""Fits of point pairs, their proofs and covariances, and what is wrong with the pairs."""
