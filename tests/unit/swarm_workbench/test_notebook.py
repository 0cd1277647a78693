"""A notebook's kernel: `await` at top level, a bar, a picture, a film, tables."""

import pytest

pytest.importorskip("ipykernel")
pytest.importorskip("ipywidgets")
nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

CELLS = (
    "from swarm_workbench import Swarm\n"
    "swarm = Swarm(robots=2, world='doorway', bench=True).start()\n"
    "start = swarm['Srobot1'].true_pose",
    "await swarm['Srobot1'].go_to((start.x + 0.5, start.y))",
    "swarm.run(seconds=1.0, progress=True)",
    "swarm.plot();",
    "swarm.film(speed=20.0)",
    "swarm.states",
    "swarm.close()",
)


def test_cells_show_what_they_are_to_show(tmp_path):
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(c) for c in CELLS])
    client = nbclient.NotebookClient(
        notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}
    )
    client.execute()
    shown = [
        {kind for output in cell.outputs for kind in output.get("data", ())}
        for cell in notebook.cells
    ]
    assert "outcome='succeeded'" in notebook.cells[1].outputs[-1]["data"]["text/plain"]
    assert shown[2]  # the bar
    assert "image/png" in shown[3]
    assert "image/gif" in shown[4]
    assert "Srobot1" in notebook.cells[5].outputs[-1]["data"]["text/plain"]
