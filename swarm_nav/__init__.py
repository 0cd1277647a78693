"""One robot: its navigator; imports swarm_common only."""
