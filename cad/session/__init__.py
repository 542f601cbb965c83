"""A part that is being taught: its rows as they are typed, what they mean, and the fit so far."""
