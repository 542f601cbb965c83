"""From the errors of observations to those of the fit and of a weld."""
