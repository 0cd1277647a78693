"""State of a swarm as the viewer knows it, and its sources: topics, messages, states, history.

What a module imports of its folder stands above it:


    link           What the address of a page carries beside its robot: camera, time, dark or light
    operator_link  What a page can tell the swarm: goals, poses, pause, robots
    topics         Topics that the view reads, and which of them a robot's layers need
    track          Robot poses between two messages: they glide from the shown pose to the true one
    decode         CDR messages to what the view draws: arrays in the map frame
    history        What has happened so far: marks, states, curves, places
    live_feed      Where messages come from; subscriptions exist only while topics are wanted
    swarm          The state of the swarm while a page is open

Imports nothing else of swarm_view.
"""
