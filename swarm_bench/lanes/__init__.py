"""Preferred lanes that are learned from where robots lose time.

Modules:
  learning  Time lost in a run, and lanes that cost it
  training  Rounds of runs and learning, and what the lanes gain on other seeds
  command   The command `swarm-bench lanes`
"""
