"""The door to the browser: the HTTP server and its checks.

What a module imports of its folder stands above it:

    http_gate  The door to the view: serves the page, asks for the token, passes websockets on

    server     viser behind our gate: the pages that connected, and their addresses

May import of swarm_view: `scene`, `state`.
"""
