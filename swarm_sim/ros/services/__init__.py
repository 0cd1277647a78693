"""The services `/sim/...`: who and what is there, whether time goes on, and questions.

What a module imports of its folder stands above it:

    model_loader  Reads models in a process beside the world, which goes on meanwhile
    places        Places and twists of robots and things as messages, and back
    request_guard  End of a request to `/sim`: whatever goes wrong with it becomes its answer
    run_state     Whether the world runs: playing, paused, or paused with steps to do
    control       Pause, step and speed of the world
    entities      Requests that change who and what is there: spawn, delete, move, reset
    inquiries     Questions, which are answered at once, and what is not supported

May import of swarm_sim: what `ros` may, but of `ros` itself nothing; and lower packages.
"""
