"""One browser page: its panel, tools, time line and charts.

What a module imports of its folder stands above it:

    charts      Curves of the run on one page: goals per minute, robots by state, smallest clearance
    driving     Driving a robot by hand from a page, like `swarm-teleop`
    inbox       What a page's own script tells: size, clicks, keys
    plan        The hall from above, in two dimensions
    panel_text  What the panel says, as Markdown and HTML
    past        The past of a live swarm on one page
    playback    The controls of a recording on a page: play, speed and where in time it is
    time_line   The time line of one page: marks of what happened, and where in time the page is
    tool        RViz's tools on one page: a place on the floor, clicked, or dragged; and a ruler
    panel       The panel of one page: its displays and buttons, widgets only
    page        One page in a browser: the robot it follows, its layers, and its orders to the swarm

May import of swarm_view: `scene`, `state`.
"""
