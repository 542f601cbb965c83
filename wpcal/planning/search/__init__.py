"""The search for plans: objectives, the ladder graph, least squares on paths, and NSGA-II."""
