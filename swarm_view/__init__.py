"""The operator's eyes: a live 3D view in the browser. Nobody imports this package."""
