"""Maps: downloaded from a server, checked against the world, enabled and deleted."""

import functools
import hashlib
import http.server
import threading
import time
import zipfile

import numpy as np
import pytest

from swarm_common.files.map_io import save_map
from swarm_common.model.errors import SwarmError
from swarm_common.model.grid import OCCUPIED, Grid
from swarm_vda5050.map_server import MapServerClient, check_map
from swarm_vda5050.maps import MOST_MAPS, Download
from tests.fakes.fleet_orders import MAP, OF_3, OF_20, Toy, action, along, node, order

LINK = "https://maps.example/hall.zip"


def hall(shift=0, resolution=0.05):
    """Return a room of 10 m, one of whose walls is moved by so many cells of 5 cm."""
    size = round(10.0 / resolution)
    cells = np.zeros((size, size), np.int8)
    cells[[0, -1], :] = cells[:, [0, -1]] = OCCUPIED
    cells[size // 2 : size // 2 + 2, : size // 2] = OCCUPIED
    return Grid(np.roll(cells, shift, axis=0), resolution, -5.0, -5.0)


@pytest.fixture
def folder(tmp_path):
    """A folder with the hall's map, a zip of it, and another one."""
    for name, grid in (("hall", hall()), ("coarse", hall(resolution=0.1)), ("other", hall(40))):
        save_map(grid, tmp_path / f"{name}.yaml")
        with zipfile.ZipFile(tmp_path / f"{name}.zip", "w") as archive:
            for ending in ("yaml", "pgm"):
                archive.write(tmp_path / f"{name}.{ending}", f"maps/{name}.{ending}")
    with zipfile.ZipFile(tmp_path / "empty.zip", "w") as archive:
        archive.writestr("readme", "nothing")
    (tmp_path / "away.yaml").write_text("image: /etc/passwd\nresolution: 0.05\norigin: [0, 0, 0]\n")
    (tmp_path / "bad.yaml").write_text("image: hall.pgm\nresolution: -1\norigin: [0, 0, 0]\n")
    return tmp_path


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.fixture
def server(folder):
    """A map server of the folder; its address."""
    handler = functools.partial(Quiet, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()
        thread.join()


def test_a_map_of_the_running_world_is_fetched_with_its_image_or_as_a_zip(server, folder):
    for name in ("hall.yaml", "hall.zip", "coarse.zip"):
        check_map(f"{server}/{name}", "", hall())
        check_map((folder / name).as_uri(), "", hall())
    data = (folder / "hall.zip").read_bytes()
    for kind in ("md5", "sha1", "sha256", "sha384", "sha512"):
        check_map(f"{server}/hall.zip", hashlib.new(kind, data).hexdigest().upper(), hall())


@pytest.mark.parametrize(
    ("name", "digest", "word"),
    [
        ("none.zip", "", "cannot be had: File not found"),
        ("other.zip", "", r"does not fit the running world: \d+ % of the walls"),
        ("hall.zip", "0" * 64, "does not have the mapHash 0000"),
        ("hall.yaml", None, "mapHash is of one file"),
        ("hall.pgm", "", "neither a YAML of a Nav2 map nor a zip"),
        ("empty.zip", "", "holds 0 YAML files"),
        ("away.yaml", "", "names no image that lies beside it"),
        ("bad.yaml", "", "bad.yaml: map.yaml: resolution is -1"),
    ],
)
def test_a_map_that_is_not_what_it_should_be_is_refused(server, folder, name, digest, word):
    if digest is None:
        digest = hashlib.sha256((folder / name).read_bytes()).hexdigest()
    with pytest.raises(SwarmError, match=word):
        check_map(f"{server}/{name}", digest, hall())


def test_a_download_tells_when_it_begins_and_ends(server):
    client = MapServerClient(hall())
    events = []
    for name in ("hall.zip", "none.zip"):
        client.begin(Download(name, f"{server}/{name}", ""))
    client.begin(Download("port", f"http://127.0.0.1:{10**20}/hall.zip", ""))  # OverflowError
    end = time.monotonic() + 60.0
    while len(events) < 6 and time.monotonic() < end:
        events += client.poll()
        time.sleep(0.01)
    problems = {event.action_id: event.problem for event in events}
    assert [event.problem for event in events].count(None) == 3
    assert problems["port"]
    assert problems["hall.zip"] == ""
    assert "cannot be had" in problems["none.zip"]


def do(toy, kind, version, key="", name=MAP, **more):
    key = key or f"{kind} {version}"
    toy.do(kind, key, mapId=name, mapVersion=version, **more)
    return toy.done[key]


def maps(toy):
    return {state.map_version: str(state.map_status) for state in toy.vehicle.maps.states}


@pytest.mark.parametrize("toy", [Toy(), Toy(OF_3)])
def test_a_map_is_downloaded_enabled_and_the_one_before_deleted(toy):
    assert do(toy, "downloadMap", "2", mapDownloadLink=LINK, mapHash="a" * 64) == "INITIALIZING"
    (download,) = toy.vehicle.take_requests().downloads
    assert download == ("downloadMap 2", LINK, "a" * 64, True)
    toy.vehicle.begin_download("downloadMap 2")
    toy.wait(100.0)
    assert toy.done["downloadMap 2"] == "RUNNING"
    assert maps(toy) == {"1": "ENABLED"}
    toy.vehicle.end_download("downloadMap 2", "")
    assert toy.done["downloadMap 2"] == "FINISHED"
    assert maps(toy) == {"1": "ENABLED", "2": "DISABLED"}
    assert do(toy, "deleteMap", "1", "in use") == "FAILED"
    assert do(toy, "enableMap", "2") == "FINISHED"
    assert maps(toy) == {"1": "DISABLED", "2": "ENABLED"}
    assert do(toy, "deleteMap", "1") == "FINISHED"
    assert toy.faults == []
    assert do(toy, "enableMap", "1", "gone") == "FAILED"
    toy.send(along(0, 1, 1))
    toy.drive()
    assert toy.vehicle.last_node == ("n1", 2)


def test_a_map_that_the_robot_has_is_not_downloaded_again_and_a_failure_is_reported():
    toy = Toy(OF_3)
    assert do(toy, "downloadMap", "1", mapDownloadLink=LINK) == "FAILED"
    assert toy.faults == ["DUPLICATE_MAP"]
    toy.do("stateRequest", "s")
    assert toy.faults == ["DUPLICATE_MAP"]  # until something about maps is accepted
    do(toy, "downloadMap", "2", mapDownloadLink=LINK)
    toy.vehicle.end_download("downloadMap 2", "nobody answers")
    assert toy.done["downloadMap 2"] == "FAILED"
    assert [(e.message, e.references["mapVersion"]) for e in toy.vehicle.errors] == [
        ("nobody answers", "2")
    ]


@pytest.mark.parametrize(
    ("more", "word"),
    [
        ({"mapDownloadLink": "ftp://maps/hall.zip"}, "expected http, https, file"),
        ({"mapDownloadLink": LINK, "mapHash": "abc"}, "expected hex of MD5"),
        ({"mapDownloadLink": LINK, "name": "hall_9"}, "is of another area"),
        ({}, "lacks the parameter 'mapDownloadLink'"),
    ],
)
def test_what_cannot_be_downloaded_is_refused_by_name(more, word):
    toy = Toy()
    assert do(toy, "downloadMap", "2", **more) == "FAILED"
    assert word in toy.vehicle.errors[0].message
    assert toy.vehicle.take_requests().downloads == ()


def test_a_robot_keeps_so_many_maps_and_none_of_2_0():
    toy = Toy()
    found = [do(toy, "downloadMap", str(k), mapDownloadLink=LINK) for k in range(2, MOST_MAPS + 2)]
    assert found == ["INITIALIZING"] * (MOST_MAPS - 1) + ["FAILED"]
    assert do(Toy(OF_20), "downloadMap", "2", mapDownloadLink=LINK) == "FAILED"


def test_a_map_is_enabled_on_a_node():
    toy = Toy()
    done = {"own": "FINISHED", "new": "FAILED"}
    enable = [
        action("enableMap", k, mapId=MAP, mapVersion=v) for k, v in zip(done, "12", strict=True)
    ]
    toy.send(order([node(0, *enable)]))
    toy.wait(0.1)
    assert toy.done == done
    assert toy.faults == ["ACTION"]
