"""The operator: bring-up, missions, reports; imports swarm_common only."""
