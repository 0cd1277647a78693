import json

import pytest

from swarm_common.model.errors import ConfigError
from swarm_sim.ros.settings import parse_settings, read_settings

BASE = {"world": "slim_blockage", "robots": [{"name": "Srobot1", "model": "turtlebot3_waffle"}]}


def test_settings_are_read_with_defaults(tmp_path):
    settings = parse_settings(BASE | {"speed": "max"}, "file")
    assert settings.speed is None
    assert settings.robots[0].name == "Srobot1"
    assert settings.radio.range == 6.0
    path = tmp_path / "world.json"
    path.write_text(json.dumps(BASE | {"radio": {"loss": 0.2}}), encoding="utf-8")
    assert read_settings(path).radio.loss == 0.2
    path.write_text("{", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"world\.json"):
        read_settings(path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sped": 1.0}, "did you mean 'seed' or 'speed'"),
        ({"speed": 0.0}, "speed is 0.0"),
        ({"robots": []}, "names no robots"),
        ({"robots": [{"nome": "x"}]}, "nome"),
        ({"radio": {"loss": 2.0}}, "loss is 2.0"),
        ({"wall_limit": 0.0}, "wall_limit"),
        ({"duration": -1.0}, "duration"),
        ({"cmd_vel_stamped": False}, "needs the stamps"),
    ],
)
def test_bad_values(changes, message):
    with pytest.raises(ConfigError) as caught:
        parse_settings(BASE | changes, "file")
    assert message in str(caught.value)
