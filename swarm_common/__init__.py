"""Vocabulary shared by the world, the robots and the operator; may be imported by every package."""
