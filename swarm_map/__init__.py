"""The command `swarm-map`: maps of worlds, and worlds of floor plans; nobody imports it."""
