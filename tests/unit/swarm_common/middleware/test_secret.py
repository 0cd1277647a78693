"""The secret of the hosts: where it comes from, and where it does not stay."""

import pytest

from swarm_common.middleware.secret import given_secret, own_secret, secret_path
from swarm_common.model.errors import ConfigError

TEXT = "sixteen letters or more"


def test_it_is_taken_out_of_the_environment_or_a_file(tmp_path):
    environment = {"SWARM_SECRET": f" {TEXT} ", "OTHER": "1"}
    assert given_secret(environment) == TEXT
    assert environment == {"OTHER": "1"}
    assert given_secret(environment) == ""
    path = tmp_path / "secret"
    path.write_text(TEXT + "\n", encoding="utf-8")
    environment = {"SWARM_SECRET_FILE": str(path)}
    assert given_secret(environment) == TEXT
    assert environment == {}


@pytest.mark.parametrize("text", ["short", "x" * 15, "x" * 1025])
def test_one_that_can_be_guessed_is_refused(text, tmp_path):
    with pytest.raises(ConfigError, match="16 or more needed"):
        given_secret({"SWARM_SECRET": text})
    path = tmp_path / "secret"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match="16 or more needed"):
        given_secret({"SWARM_SECRET_FILE": str(path)})


def test_a_file_that_is_not_there_or_empty(tmp_path):
    with pytest.raises(ConfigError, match="cannot be read"):
        given_secret({"SWARM_SECRET_FILE": str(tmp_path / "none")})
    (tmp_path / "empty").touch()
    with pytest.raises(ConfigError, match="has 0 characters"):
        given_secret({"SWARM_SECRET_FILE": str(tmp_path / "empty")})


def test_the_worlds_host_makes_one_and_keeps_it_where_it_can(tmp_path):
    environment = {"XDG_STATE_HOME": str(tmp_path)}
    made = own_secret(environment)
    assert len(made) >= 16
    assert own_secret(environment) == made
    assert own_secret({**environment, "SWARM_SECRET": TEXT}) == TEXT
    path = secret_path(environment)
    assert path.stat().st_mode & 0o777 == 0o600
    path.chmod(0o644)  # others may have read it
    assert own_secret(environment) != made
    assert path.stat().st_mode & 0o777 == 0o600
    blocked = tmp_path / "file"
    blocked.touch()
    environment = {"XDG_STATE_HOME": str(blocked)}
    assert own_secret(environment) != own_secret(environment)
