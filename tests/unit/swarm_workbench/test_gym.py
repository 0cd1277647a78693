"""Environments: the checks of their makers, seeds, the shield."""

import gc
import weakref

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import parallel_api_test, parallel_seed_test

from swarm_common.model.errors import SwarmError
from swarm_workbench.gym import RobotEnv, SwarmEnv, TeamEnv

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")


def test_the_checks_of_pettingzoo_and_gymnasium_pass():
    parallel_api_test(SwarmEnv(3), num_cycles=100)
    parallel_seed_test(lambda: SwarmEnv(3), num_cycles=30)
    check_env(RobotEnv(3), skip_render_check=True)
    check_env(TeamEnv(3), skip_render_check=True)


def test_an_observation_is_seen_from_the_robot():
    env = SwarmEnv(2, "doorway", neighbours=3)
    starts = [(-4.0, 0.0, np.pi / 2), (-3.0, 0.0, 0.0)]
    observations, _ = env.reset(options={"starts": starts, "goals": [(-4.0, 2.0), (-3.0, 1.0)]})
    seen = observations["Srobot1"]
    assert seen["goal"] == pytest.approx([2.0, 0.0], abs=1e-6)
    assert seen["neighbours"][0] == pytest.approx([1, 0, -1, -np.pi / 2, 0, 0], abs=1e-6)
    assert not seen["neighbours"][1:].any()
    assert env.observation_space("Srobot1").contains(seen)


def test_a_goal_ends_an_episode_with_its_reward():
    env = SwarmEnv(1, "doorway")
    env.reset(options={"starts": [(-4.0, 0.0, 0.0)], "goals": [(-3.0, 0.0)]})
    gained = 0.0
    while env.agents:
        _, rewards, ends, _, infos = env.step({"Srobot1": [0.26, 0.0]})
        gained += rewards["Srobot1"]
    assert ends["Srobot1"]
    assert infos["Srobot1"] == {"reached": True, "contact": False}
    assert gained > 10.0


def _contacts(shield, ticks):
    """Return the contacts of robots that drive at each other and into walls at random."""
    env = SwarmEnv(4, "doorway", shield=shield, limit=1e6)
    random, contacts = np.random.default_rng(1), 0
    for tick in range(ticks):
        if tick % 150 == 0:
            env.reset(seed=tick)
        if tick % 20 == 0:
            actions = {
                name: random.uniform(-1.0, 1.0, 2) * env.action_space(name).high
                for name in env.possible_agents
            }
        if not env.agents:
            continue
        infos = env.step(actions)[4]
        contacts += sum(info["contact"] for info in infos.values())
    return contacts


def test_the_shield_keeps_robots_apart():
    assert _contacts(shield=False, ticks=900) > 0
    assert _contacts(shield=True, ticks=900) == 0


def test_an_environment_that_is_thrown_away_is_freed():
    """A cache of the class kept each of them, 0.9 MB."""
    env = SwarmEnv(2, "hall_12")
    assert env.action_space("Srobot1") is env.action_space("Srobot1")
    assert env.observation_space("Srobot1") is not env.observation_space("Srobot2")
    left = weakref.ref(env)
    env.close()
    del env
    gc.collect()
    assert left() is None


def test_copies_in_processes_do_what_one_does_here():
    team = TeamEnv(3)
    copies = gymnasium.vector.AsyncVectorEnv([lambda: TeamEnv(3)] * 2)
    try:
        seen, _ = copies.reset(seed=[5, 6])
        assert seen["scan"].shape[:2] == (2, 3)
        team.reset(seed=6)
        for _ in range(5):
            actions = np.full((2, 3, 2), 0.2, np.float32)
            seen, rewards, *_, infos = copies.step(actions)
            alone, reward, *_, info = team.step(actions[1])
        assert np.array_equal(seen["scan"][1], alone["scan"])
        assert rewards[1] == pytest.approx(reward)
        assert np.allclose(infos["rewards"][1], info["rewards"])
    finally:
        copies.close()


def test_numbers_that_make_no_sense_are_refused():
    for options in ({"robots": 0}, {"limit": 0.0}, {"world": "no_such"}, {"robots": 500}):
        with pytest.raises(SwarmError):
            SwarmEnv(**options).reset()
