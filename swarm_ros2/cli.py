"""Entry point of the `ros2` command."""

from __future__ import annotations


def main() -> None:
    """Run the command."""
