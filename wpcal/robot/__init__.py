"""Robot arms: modified Denavit-Hartenberg models, kinematics both ways, and identification of their parameters."""
