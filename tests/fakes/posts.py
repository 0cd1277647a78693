"""Posts around a robot, and whether its scans show them where they are."""

import math

import numpy as np

from swarm_common.model.records import FloatArray, Pose, Scan
from swarm_common.model.shapes import Box, Part
from swarm_describe.robots.description import parse_urdf
from swarm_describe.robots.loading import Robot
from swarm_describe.worlds.scene import Body


def post(x: float, y: float) -> Body:
    place = np.eye(4)
    place[:3, 3] = (x, y, 0.5)
    return Body(f"post_{x}_{y}", place, (Part(Box((0.2, 0.2, 1.0)), np.eye(4)),))


def points_by_tf(scan: Scan, made: Robot, pose: Pose) -> FloatArray:
    """What RViz shows: the ranges in the scan's frame, through the description, in map."""
    model = parse_urdf(made.urdf, "", (*made.spec.wheels_left, *made.spec.wheels_right))
    angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    hits = np.isfinite(scan.ranges)
    flat = np.column_stack([np.cos(angles), np.sin(angles)])[hits] * scan.ranges[hits, None]
    points = np.column_stack([flat, np.zeros(len(flat)), np.ones(len(flat))])
    base = (points @ model.fixed["base_scan"].T)[:, :2]
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    return base @ np.array([[cos, sin], [-sin, cos]]) + [pose.x, pose.y]


def off_the_posts(points: FloatArray, posts: tuple[Body, ...]) -> float:
    """How far [m] the point furthest from the outlines of the posts is away."""
    gaps = []
    for body in posts:
        off = np.abs(points - body.world_from_body[:2, 3]) - 0.1
        outside = np.hypot(*np.maximum(off, 0.0).T)
        gaps.append(np.where((off < 0.0).all(axis=1), -off.max(axis=1), outside))
    return float(np.min(gaps, axis=0).max())
