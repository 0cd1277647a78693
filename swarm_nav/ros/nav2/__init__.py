"""Nav2's actions, services and topics, as clients of Nav2 know them.

What a module imports of its folder stands above it:

    demand              Servers and topics that exist only once somebody looks for them
    map_bounds          Largest distances from the map of a place, a path or an odometry reading
    costmaps            A costmap on Nav2's topics: whole and in parts, as occupancy and raw
    goals               Nav2's action goals, feedback and results, to and from the brain's
    lifecycle_services  Nav2's nodes as the graph shows them: names with lifecycle services
    served_node         The navigator's node, as far as actions and services need it
    plans               Nav2's planning actions: a leg at a time, so that no tick has to wait
    poses               Poses that arrive with a frame, in map
    services            Nav2's services on the node: lifecycle, costmaps, map
    tasks               Nav2's navigation actions and goal_pose
    views               Topics for viewers, sent only while they subscribe

May import of swarm_nav: what `ros` may, but of `ros` itself nothing; and swarm_common.
"""
