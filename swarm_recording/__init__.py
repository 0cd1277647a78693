"""Recordings: MCAP bags of a swarm's topics, and playing them. May import swarm_common only."""
