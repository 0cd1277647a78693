"""One robot's navigator on the ROS graph: topics in, one call of the brain per tick, topics out."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav2_msgs.msg import SpeedLimit
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Odometry as OdometryMsg
from rclpy.context import Context
from sensor_msgs.msg import BatteryState, LaserScan
from swarm_interfaces.msg import Mission, NeighborArray, RobotStatus

from swarm_common.middleware import cdr, central_io, courier_io, directed_io, ros_io
from swarm_common.middleware.radio_check import read_neighbors
from swarm_common.middleware.rejections import RejectedError, Rejections
from swarm_common.middleware.ros_poll import PolledTopic, SoleTopic
from swarm_common.model.battery import SupplyStatus
from swarm_common.model.beacon import reception_of
from swarm_common.model.central import Coordination
from swarm_common.model.errors import MapError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose
from swarm_common.process.pipes import EventWriter
from swarm_nav.behaviour.plugin_brain import make_brain
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import GoalEnded, Output
from swarm_nav.core.lifecycle import Lifecycle
from swarm_nav.interfaces import Led, RobotBrain
from swarm_nav.ros.answer import Answers
from swarm_nav.ros.bare_node import TickClock, create_node
from swarm_nav.ros.centre_link import CentreLink
from swarm_nav.ros.courier_link import CourierLink
from swarm_nav.ros.inputs import TickInput, TickInputs
from swarm_nav.ros.nav2.demand import OnDemand
from swarm_nav.ros.nav2.goals import speed_limit_in
from swarm_nav.ros.nav2.lifecycle_services import LifecycleServices
from swarm_nav.ros.nav2.map_bounds import MapBounds
from swarm_nav.ros.nav2.plans import Plans
from swarm_nav.ros.nav2.poses import deviation_in, is_placeholder, pose_in_map
from swarm_nav.ros.nav2.services import NavServices
from swarm_nav.ros.nav2.tasks import Tasks
from swarm_nav.ros.nav2.views import Views
from swarm_nav.ros.params import Parameters
from swarm_nav.ros.settings import NodeSettings
from swarm_nav.ros.status import StatusWriter

WORLD_SPACE = "/sim/"  # namespace of the world's nodes
STATUS_TICKS = 5  # 2 Hz
CLOCK_TICKS = 10  # for messages that rclpy itself stamps; our own messages carry the tick
STATUS_PERIOD = 0.4  # [s] of wall time between two statuses without a change
KEEPOUT = "keepout_filter_mask"  # topic of a mask besides the zones of the world, as in Nav2
ODOM_ORIGIN = Pose(0.0, 0.0, 0.0)  # where odometry begins


class NavigatorNode:
    """The node `NAME/navigator`. It becomes active when the map has arrived.

    Attributes:
        node: For an executor.
        lifecycle: Nav2's, of the whole navigator.
        tick: The present control tick.
        map_bounds: Bounds of the current map, once there is one.
        rejections: Rejections by the doors of this navigator.
    """

    def __init__(
        self,
        settings: NodeSettings,
        context: Context,
        on_active: Callable[[], None],
        events: EventWriter,
    ) -> None:
        """Create the node and wait for the map.

        Args:
            on_active: Called once, when the navigator is active for the first time.
        """
        self._settings = settings
        self._config: NavConfig = settings.config
        self._on_active: Callable[[], None] | None = on_active
        self._brain: RobotBrain | None = None
        self._centre: CentreLink | None = None
        self.lifecycle = Lifecycle()
        self.tick = 0
        scan_every = settings.spec.lidar.period_ticks if settings.fixed["with_lidar"] else 0
        self._inputs = TickInputs(scan_every, has_battery=settings.spec.battery is not None)
        self._last_status = 0.0  # wall time
        self._was_pausing = False
        self._is_charging = False
        self._status_writer = StatusWriter(settings.name)
        self.node = create_node(settings, context)
        self.rejections = Rejections(events, self.node.get_logger().warning)
        self._answers = Answers(
            self.node,
            waits_for_mission=bool(settings.fixed["wait_for_mission"]),
            has_courier=bool(settings.fixed["wait_for_courier"]),
        )
        self._courier: CourierLink | None = None
        self._pending: TickInput | None = None  # of the present tick, while the centre is to speak
        self._clock = TickClock(self.node) if settings.fixed["use_sim_time"] else None
        self._on_demand = OnDemand(self.node, is_eager=not settings.fixed["on_demand"])
        self._parameters = Parameters(
            self.node, settings, self._reconfigure, self._on_demand, self.rejections
        )
        self._map_subscription = self.node.create_subscription(
            OccupancyGrid, "/map", self._receive_map_msg, ros_io.LATCHED, raw=True
        )

    def _receive_map_msg(self, data: bytes) -> None:
        """Receive the map of the robot's parameter file from any sender, and no other map."""
        try:
            message = ros_io.unpacked(data, OccupancyGrid)
            wanted = str(self._settings.fixed["map_sha256"])
            if wanted and (found := ros_io.message_digest(message)) != wanted:
                raise RejectedError(
                    f"a map with the digest {found[:12]}; map_sha256 in the robot's parameters"
                    f" begins with {wanted[:12]}"
                )
            grid = ros_io.grid_from_msg(message).upright().refined()
        except (RejectedError, MapError) as error:
            self.rejections.reject("map", "a publisher of /map", error)
            return
        if self._brain is None:
            self._begin(grid)
        else:
            self.receive_map(grid)

    def _begin(self, grid: Grid) -> None:
        """Create the brain and everything that needs it."""
        settings = self._settings
        brain = make_brain(
            self._config,
            settings.spec,
            grid,
            settings.sites,
            settings.robot_id,
            settings.initial_pose_map,
            settings.names,
        )
        self._brain = brain
        self._measure(grid)
        self._answers.announce()
        self._status = self.node.create_publisher(RobotStatus, "status", ros_io.RELIABLE)
        self._views = Views(self.node, brain.services, settings.spec, self._on_demand)
        self._tasks = Tasks(self, brain, self._answers.on_goal, self._on_demand)
        self._plans = Plans(self, brain.services, self._on_demand)
        NavServices(self, brain.services, self._on_demand)
        self._lifecycle_services = LifecycleServices(
            self.node, self.lifecycle, self.change_lifecycle, self._on_demand
        )
        is_led = self._config.traffic.coordination != Coordination.DECENTRAL
        if is_led and isinstance(brain, Led):
            self._centre = CentreLink(self.node, brain, settings.robot_id, self.rejections)
        self._subscribe()
        if not settings.fixed["autostart"]:
            brain.services.deactivate()
        else:
            self.change_lifecycle("startup")

    def _subscribe(self) -> None:
        self._topics = {
            "odom": self._hear(OdometryMsg, "odom"),
            "scan": self._hear(LaserScan, "scan"),
            "neighbors": self._hear(NeighborArray, "neighbors"),
        }
        takers: dict[str, Callable[[bytes], TickInput | None]] = {
            "odom": self._receive_odom,
            "scan": self._receive_scan,
        }
        if self._settings.spec.battery is not None:
            self._topics[ros_io.BATTERY] = self._hear(BatteryState, ros_io.BATTERY)
            takers[ros_io.BATTERY] = self._take_battery
        takers["neighbors"] = self._receive_neighbors  # which comes last
        if self._centre is not None:
            self._topics[central_io.ORDERS] = self._centre.topic
            takers[central_io.ORDERS] = self._receive_orders
        if self._settings.fixed["wait_for_courier"]:
            self._courier = CourierLink(self.node, self.rejections)
            self._topics[courier_io.RELEASE] = self._courier.topic
            takers[courier_io.RELEASE] = self._receive_release
        self._incoming = [(name, self._topics[name], take) for name, take in takers.items()]
        make = self.node.create_subscription
        kind, quality = PoseWithCovarianceStamped, ros_io.RELIABLE
        make(kind, "initialpose", self._receive_initial_pose, quality, raw=True)
        make(Mission, "mission", self._receive_mission, ros_io.LATCHED, raw=True)
        take = self._take_speed_limit
        self._on_demand.offer_input(
            "speed_limit", partial(make, SpeedLimit, "speed_limit", take, quality, raw=True)
        )
        mask, latched = self._take_keepout_mask, ros_io.LATCHED
        self._on_demand.offer_input(
            KEEPOUT, partial(make, OccupancyGrid, KEEPOUT, mask, latched, raw=True)
        )
        zones, name = self._take_directed_zones, directed_io.TOPIC
        subscribe = partial(make, directed_io.KIND, name, zones, latched, raw=True)
        self._on_demand.offer_input(name, subscribe, is_rare=True)

    def _hear(self, kind: Any, name: str) -> SoleTopic:
        """Listen to the world, or without one to any publisher of the robot's sensors."""
        return SoleTopic(
            self.node,
            kind,
            name,
            ros_io.TICK_INPUT,
            lambda who: who.startswith(WORLD_SPACE),
            lambda who: self.rejections.reject(name, who, "another node is heard here"),
        )

    @property
    def is_in_large_swarm(self) -> bool:
        """Whether rarely used services are created only for their first client."""
        return bool(self._settings.fixed["on_demand"])

    # What a tick is made of

    @property
    def awaited(self) -> PolledTopic | None:
        """Topic of the input that the present tick lacks; None if the executor must run first.

        The world publishes `neighbors` after `odom` and `scan`, but a network may deliver them in
        another order. Without a map, or while an answer is withheld, only the executor can bring
        what is missing.
        """
        if self._brain is None:
            return None
        if self._pending is not None:
            return self._topics[central_io.ORDERS]
        if not self._answers.is_withheld:
            return self._topics[self._inputs.missing]
        is_released = self._courier is None or self._missing_goals is not None
        return None if is_released else self._topics[courier_io.RELEASE]

    def receive_inputs(self) -> None:
        """Receive the messages of the tick that have arrived; decide if it is complete.

        Of each topic one message at a time, and no more once a tick is complete: a look at what
        is empty costs as much as a message.
        """
        if self._brain is None:
            return
        self._release()
        self._decide()
        has_taken = True
        while has_taken:
            has_taken = False
            for name, topic, take in self._incoming:
                if (data := topic.take()) is not None:
                    has_taken = True
                    try:
                        step = take(data)
                    except RejectedError as error:
                        self.rejections.reject(name, "the world", error)
                        continue
                    self._step(step)
            if self._inputs.is_settled:
                return

    def _receive_odom(self, data: bytes) -> TickInput | None:
        odom = self._odometry_reader.read(data)
        if self._inputs.is_repeat(odom.tick):
            self._answers.repeat()
            if self._courier is not None and self._answers.is_withheld:
                self._courier.repeat()
            if self._centre is not None and self._pending is not None:
                self._centre.repeat()
        return self._inputs.add_odom(odom)

    def _receive_scan(self, data: bytes) -> TickInput | None:
        return self._inputs.add_scan(cdr.read_scan(data))

    def _take_battery(self, data: bytes) -> TickInput | None:
        return self._inputs.add_battery(ros_io.read_battery(data))

    def _receive_neighbors(self, data: bytes) -> TickInput | None:
        tick, beacons, reason = read_neighbors(data, self._settings.robot_id)
        if reason:
            self.rejections.reject("neighbors", "the world", reason)
        return self._inputs.add_neighbors(tick, beacons)

    def _receive_release(self, data: bytes) -> None:
        """Receive a release; what one that comes too late says counts from now on."""
        courier = self._courier
        assert courier is not None
        courier.receive(data)
        if courier.release is None or not self._answers.is_withheld:
            self._obey()
        self._release()

    @property
    def _missing_goals(self) -> Sequence[bytes] | None:
        """Goals that the courier sent in this tick and that are on their way; None before that."""
        courier = self._courier
        tasks = self._tasks
        return None if courier is None else courier.missing_goals(tasks.knows, tasks.is_cancelled)

    def _release(self) -> None:
        """Answer the tick if the courier has released it and its goals are there."""
        if self._answers.is_withheld and self._missing_goals == []:
            self._obey()
            self._answers.send_withheld()

    def _obey(self) -> None:
        """Obey the limits that were told with the latest release, and wait for the next one."""
        assert self._brain is not None
        assert self._courier is not None
        release = self._courier.obey()
        if release is None:
            return
        self._answers.expect_release()
        if release.speed_limit is not None:
            self._brain.services.on_speed_limit(release.speed_limit, is_percentage=False)
        if release.keepout:
            self._take_keepout_mask(release.keepout)
        if release.directed:
            self._take_directed_zones(release.directed)

    def _receive_orders(self, data: bytes) -> None:
        assert self._centre is not None
        self._centre.receive(data)

    def _step(self, observed: TickInput | None) -> None:
        """Decide on a tick that is complete, or on one that waited for the centre."""
        if observed is not None:
            self._pending = observed
        self._decide()

    def _decide(self) -> None:
        """Decide on the tick that is complete, unless the centre has to speak first."""
        brain, observed = self._brain, self._pending
        if observed is None or brain is None:
            return
        if self._centre is not None and not self._centre.has_spoken(time.monotonic()):
            return
        self._pending = None
        self.tick = tick = observed.tick
        assert observed.odom is not None
        assert observed.neighbors is not None
        brain.on_odom(observed.odom)
        if self._answers.is_first and observed.odom.pose_odom != ODOM_ORIGIN:
            self._rejoin(brain, observed.odom.pose_odom)
        if observed.scan is not None:
            brain.on_scan(observed.scan)
        if observed.battery is not None:
            brain.on_battery(observed.battery)
            self._is_charging = observed.battery.status is SupplyStatus.CHARGING
        brain.on_reception(reception_of(observed.neighbors))
        output = brain.tick(tick)
        if self._centre is not None:
            self._centre.send(tick)
        ended = [event for event in output.events if isinstance(event, GoalEnded)]
        has_goal = brain.services.goal_id is not None
        self._answers.give(tick, output, has_goal=has_goal, has_ended=bool(ended))
        if (courier := self._courier) is not None:
            tasks = self._tasks
            courier.report(
                tick, brain.status(), tasks.goal, tasks.ended_of(ended), tasks.refusal_of,
                is_charging=self._is_charging,
            )  # fmt: skip
        self._tell(output, ended)

    def _rejoin(self, brain: RobotBrain, pose_odom: Pose) -> None:
        """Continue where the odometry is: it began at the initial pose, with another navigator."""
        pose_map = self._settings.initial_pose_map.compose(pose_odom)
        brain.services.on_initial_pose(pose_map)
        self.node.get_logger().info(
            f"the odometry has gone on since the start: at ({pose_map.x:.2f}, {pose_map.y:.2f})"
        )

    def _tell(self, output: Output, ended: list[GoalEnded]) -> None:
        now = time.monotonic()  # at full speed, 2 Hz of simulated time would be 10 Hz and more
        is_due = self.tick % STATUS_TICKS == 0 and now - self._last_status > STATUS_PERIOD
        is_pausing = self._brain is not None and self._brain.services.is_pausing
        has_begun = is_pausing and not self._was_pausing  # which is no event of the brain
        self._was_pausing = is_pausing
        if output.events or is_due or has_begun:
            self._last_status = now
            self.publish_status()
        if self._clock is not None and self.tick % CLOCK_TICKS == 0:
            self._clock.set(self.tick)
        self._tasks.report(self.tick, ended)
        self._views.publish(self.tick)

    def look_around(self, now: float, has_graph_changed: bool) -> None:
        """Check for clients, for plans that wait, and for a mission that has been silent too long.

        Args:
            now: [s] of wall time.
            has_graph_changed: Whether the ROS graph has since the last call.
        """
        # The first tick was answered by all before there is a second one.
        self._on_demand.look(now, has_begun=self.tick > 0, has_changed=has_graph_changed)
        self._answers.look(self.tick, now)
        if self._brain is not None:
            self._plans.look(self.tick)
        self.rejections.tell(now)

    # What the operator asks for

    def _receive_mission(self, data: bytes) -> None:
        try:
            self._answers.receive_mission(ros_io.unpacked(data, Mission))
        except RejectedError as error:
            self.rejections.reject("mission", "an operator", error)

    def _take_speed_limit(self, data: bytes) -> None:
        try:
            limit, is_percentage = speed_limit_in(ros_io.unpacked(data, SpeedLimit))
        except RejectedError as error:
            self.rejections.reject("speed_limit", "a client", error)
            return
        if self._brain is not None:
            self._brain.services.on_speed_limit(limit, is_percentage=is_percentage)

    def _take_keepout_mask(self, data: bytes) -> None:
        assert self._brain is not None
        try:
            mask = ros_io.grid_from_msg(ros_io.unpacked(data, OccupancyGrid)).upright()
            self._brain.services.on_keepout_mask(mask)
        except (RejectedError, MapError) as error:
            self.rejections.reject(KEEPOUT, "a client", error)

    def _take_directed_zones(self, data: bytes) -> None:
        assert self._brain is not None
        try:
            self._brain.services.on_directed_zones(directed_io.read_zones(data))
        except RejectedError as error:
            self.rejections.reject(directed_io.TOPIC, "a client", error)

    def _receive_initial_pose(self, data: bytes) -> None:
        brain = self._brain
        assert brain is not None
        try:
            message = ros_io.unpacked(data, PoseWithCovarianceStamped)
            stamped = PoseStamped(header=message.header, pose=message.pose.pose)
            pose_map = self.to_map(stamped)
            if not self.map_bounds.has(pose_map):
                raise RejectedError(f"({pose_map.x:g}, {pose_map.y:g}) is not on the map")
        except ValueError as error:
            self.rejections.reject("initialpose", "a client", error)
            return
        if is_placeholder(stamped):
            self.node.get_logger().warning(
                "initialpose: (0, 0, 0) without a stamp is taken for a client's default and"
                " ignored; a stamp makes it count",
                once=True,
            )
        else:
            brain.services.on_initial_pose(pose_map, deviation_in(message.pose.covariance))
        self._views.publish_pose(self.tick)

    def to_map(self, stamped: PoseStamped) -> Pose:
        """Return a pose of one of the robot's frames in map, not far off it; there has to be a map.

        Args:
            stamped: In map, odom, or a link fixed to the robot; an empty frame means map.

        Raises:
            ValueError: If the frame is unknown, a number makes no sense, or the pose is far off the
                map.
        """
        assert self._brain is not None
        own = self._settings
        return self.map_bounds.check(
            pose_in_map(self._brain.services, own.name, own.frames, stamped)
        )

    def receive_map(self, grid: Grid) -> None:
        """Navigate on another map from now on; before the first one this does nothing.

        Args:
            grid: Upright, in the same map frame.

        Raises:
            MapError: If the map has too many cells when it is divided into finer ones.
        """
        if self._brain is not None:
            self._brain.services.load_map(grid)
            self._measure(grid)

    def _measure(self, grid: Grid) -> None:
        """Record how far away anything can be on a map."""
        self.map_bounds = MapBounds.of(grid)
        self._odometry_reader = cdr.OdometryReader(self.map_bounds.most_odometry)

    def _reconfigure(self, config: NavConfig) -> None:
        self._config = config
        if self._brain is not None:
            self._brain.services.reconfigure(config)

    def change_lifecycle(self, command: str) -> bool:
        """Carry out a command of the lifecycle manager.

        Args:
            command: Name of a transition in `core.lifecycle`, like `startup` or `pause`.

        Returns:
            False if it makes no sense now, as any does before there is a map.
        """
        brain = self._brain
        if brain is None or not self.lifecycle.apply(command):
            return False
        if self.lifecycle.is_active:
            brain.services.activate()
            self._views.publish_pose(self.tick)
            if self._on_active is not None:
                self._on_active()
                self._on_active = None
        else:
            brain.services.deactivate()
        self.publish_status()
        return True

    def publish_status(self) -> None:
        """Publish the state for the operator."""
        if self._brain is not None:
            self._status.publish(self._status_writer.encode(self.tick, self._brain.status()))

    def destroy(self) -> None:
        """Leave the ROS graph."""
        if self._brain is not None:
            for topic in self._topics.values():
                topic.destroy()
            self._lifecycle_services.destroy()
        self.node.destroy_node()
