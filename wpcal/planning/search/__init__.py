"""The search for plans: targets, objectives, the ladder graph, least squares on whole paths, and NSGA-II."""
