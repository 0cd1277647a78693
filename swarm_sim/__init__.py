"""The world: physics, sensing, radio and ground truth; imports swarm_common only."""
