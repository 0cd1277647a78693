"""Controllers: twists with which a robot follows the path that it holds.

What a module imports of its folder stands above it:

    dwa_kernels    Bare numba kernels of the dynamic window
    omni_kernels   Bare numba kernel of the dynamic window for drives that move in any direction
    controller     Local controller: rotation shim and DWA along the held tube
    plugin_controller  A controller that a user brings, behind the face of the built-in one
    omni           Local controller of drives that move in any direction: DWA with a speed sideways

May import of swarm_nav: `reservation`, `perception`, `planning`, `interfaces`,
`core`; and swarm_common.
"""
