"""Topics that a navigator shows to viewers, sent only while they subscribe."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import PolygonStamped, PoseWithCovarianceStamped
from nav2_msgs.msg import Particle, ParticleCloud
from nav_msgs.msg import Path
from rclpy.node import Node
from rclpy.publisher import Publisher
from tf2_msgs.msg import TFMessage

from swarm_common.middleware import cdr, ros_io
from swarm_common.model.records import Pose, RobotSpec
from swarm_nav.interfaces import Services
from swarm_nav.ros.nav2.costmaps import CostmapTopics
from swarm_nav.ros.nav2.demand import OnDemand

LOOK_TICKS = 10  # between two looks for subscribers
PLAN_TICKS = 5
LOCAL_TICKS = 2  # Nav2's 5 Hz
GLOBAL_TICKS = 10  # Nav2's 1 Hz
POSE_TICKS = 10


class Views:
    """The publishers for RViz and its like, on one node."""

    def __init__(
        self, node: Node, services: Services, spec: RobotSpec, on_demand: OnDemand
    ) -> None:
        """Create the publishers, but for what few listen to.

        Args:
            services: Plans, costmaps and poses that are shown.
            on_demand: Receives the topics that few listen to.
        """
        self._services = services
        make = node.create_publisher
        self._plan = make(Path, "plan", ros_io.LATEST)
        self._local_plan = make(Path, "local_plan", ros_io.LATEST)
        self._costmaps = [
            CostmapTopics(node, space, period, compose, on_demand)
            for space, period, compose in (
                ("local_costmap", LOCAL_TICKS, services.local_costmap),
                ("global_costmap", GLOBAL_TICKS, services.global_costmap),
            )
        ]
        self._footprint = make(PolygonStamped, "local_costmap/published_footprint", ros_io.LATEST)
        self._amcl_pose = make(PoseWithCovarianceStamped, "amcl_pose", ros_io.LATCHED)
        self._particles = make(ParticleCloud, "particle_cloud", ros_io.SENSOR)
        self._tf = make(TFMessage, "tf", ros_io.TRANSFORMS)
        self._pose_writer = cdr.CovariantPoseWriter("map")
        self._wanted: set[Publisher] = set()
        self._footprint_base = np.array(spec.footprint)

    def publish(self, tick: int) -> None:
        """Publish what is wanted and due at this tick."""
        if tick % LOOK_TICKS == 0:
            self._poll_subscribers()
        if tick % POSE_TICKS == 0:
            self.publish_pose(tick)
        for costmap in self._costmaps:
            costmap.publish(tick)
        if not self._wanted:
            return
        if self._is_due(self._tf, tick, 1):
            pose = self._services.map_from_odom
            self._tf.publish(
                TFMessage(transforms=[ros_io.planar_transform("map", "odom", pose, tick)])
            )
        if self._is_due(self._plan, tick, PLAN_TICKS):
            self._plan.publish(ros_io.path_msg(self._services.plan_map(), tick))
        if self._is_due(self._local_plan, tick, LOCAL_TICKS):
            self._local_plan.publish(ros_io.path_msg(self._services.local_plan_map(), tick))
        if self._is_due(self._footprint, tick, LOCAL_TICKS):
            self._publish_footprint(tick)
        if self._is_due(self._particles, tick, PLAN_TICKS):
            self._publish_particles(tick)

    def publish_pose(self, tick: int) -> None:
        """Publish the estimated pose; the last one stays for late subscribers."""
        pose, variances = self._services.pose_map, self._services.variances()
        self._amcl_pose.publish(self._pose_writer.encode(tick, pose, variances))

    def _poll_subscribers(self) -> None:
        for costmap in self._costmaps:
            costmap.poll_subscribers()
        heavy = (self._plan, self._local_plan, self._footprint, self._particles, self._tf)
        self._wanted = {topic for topic in heavy if topic.get_subscription_count() > 0}

    def _is_due(self, topic: Publisher, tick: int, period: int) -> bool:
        return topic in self._wanted and tick % period == 0

    def _publish_footprint(self, tick: int) -> None:
        pose = self._services.pose_map
        cos, sin = np.cos(pose.yaw), np.sin(pose.yaw)
        corners_map = self._footprint_base @ np.array([[cos, sin], [-sin, cos]]) + (pose.x, pose.y)
        message = PolygonStamped(header=ros_io.header(tick, "map"))
        message.polygon.points = ros_io.points32(corners_map)
        self._footprint.publish(message)

    def _publish_particles(self, tick: int) -> None:
        particles = self._services.particles()
        message = ParticleCloud(header=ros_io.header(tick, "map"))
        weight = 1.0 / max(1, len(particles))
        message.particles = [
            Particle(pose=ros_io.pose_msg(Pose(float(x), float(y), float(yaw))), weight=weight)
            for x, y, yaw in particles
        ]
        self._particles.publish(message)
