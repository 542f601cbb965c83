"""Arms: Denavit-Hartenberg chains, forward and inverse kinematics, files of arms."""
