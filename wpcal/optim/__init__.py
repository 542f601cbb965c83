"""Solvers that know no geometry: they see a batched cost function and bounds."""
