"""Environments: the checks of their makers, arguments, spaces, rewards, copies, the shield."""

import copy
import gc
import pickle
import re
import weakref

import gymnasium
import numpy as np
import pettingzoo
import pytest
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import parallel_api_test, parallel_seed_test

from swarm_common.model.errors import SwarmError
from swarm_workbench import reward
from swarm_workbench.gym import RobotEnv, SwarmEnv, TeamEnv, make_vec
from swarm_workbench.observation import PolicyConfig
from swarm_workbench.team import EnvOptions

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")
FLAT = {"observation": "flat", "normalise": True, "rays": 36, "stack": 2, "ticks": 2}
ALL = {"parts": ("scan", "goal", "way", "twist", "neighbours", "precedence")}
OPTIONS = [{}, FLAT, {**ALL, "normalise": True}, {**FLAT, **ALL, "neighbours_as": "image"}]


@pytest.mark.parametrize("options", OPTIONS)
def test_the_checks_of_pettingzoo_and_gymnasium_pass(options):
    parallel_api_test(SwarmEnv(3, **options), num_cycles=60)
    parallel_seed_test(lambda: SwarmEnv(3, **options), num_cycles=20)
    check_env(RobotEnv(3, **options), skip_render_check=True)
    check_env(TeamEnv(3, **options), skip_render_check=True)


def test_supersuits_wrappers_take_it():
    supersuit = pytest.importorskip("supersuit", reason="SuperSuit comes with the extra `train`")
    env = supersuit.black_death_v3(SwarmEnv(3, limit=2.0, **FLAT))
    parallel_api_test(env, num_cycles=60)
    rows = supersuit.concat_vec_envs_v1(supersuit.pettingzoo_env_to_vec_env_v1(env), 2)
    seen, _ = rows.reset(seed=0)
    assert seen.shape == (6, *env.observation_space("Srobot1").shape)
    for _ in range(30):
        rows.step(np.zeros((6, 2), np.float32))


def test_they_are_registered():
    env = gymnasium.make("swarm_workbench/Robot-v0", robots=2)
    env.reset(seed=0)
    team = gymnasium.make("swarm_workbench/Team-v0", robots=2, world="hall_12")
    assert team.action_space.shape == (2, 2)
    swarm = pettingzoo.make("parallel", "swarm_workbench/Swarm-v0", robots=3)
    assert swarm.possible_agents == ["Srobot1", "Srobot2", "Srobot3"]
    assert gymnasium.make_vec("swarm_workbench/Robot-v0", num_envs=3).num_envs == 3


def test_an_observation_is_seen_from_the_robot():
    env = SwarmEnv(2, "doorway", neighbours=3)
    starts = [(-4.0, 0.0, np.pi / 2), (-3.0, 0.0, 0.0)]
    observations, _ = env.reset(options={"starts": starts, "goals": [(-4.0, 2.0), (-3.0, 1.0)]})
    seen = observations["Srobot1"]
    assert seen["goal"] == pytest.approx([2.0, 0.0], abs=1e-6)
    assert seen["neighbours"][0] == pytest.approx([1, 0, -1, -np.pi / 2, 0, 0], abs=1e-6)
    assert not seen["neighbours"][1:].any()
    assert env.observation_space("Srobot1").contains(seen)


def test_a_normalised_one_tells_the_same():
    env = SwarmEnv(2, "doorway", normalise=True, neighbours_as="image", **ALL)
    starts = [(-4.0, 2.0, np.pi / 2), (-3.3, 1.9, np.pi)]
    observations, _ = env.reset(options={"starts": starts, "goals": [(4.0, 2.0), (-3.0, 1.0)]})
    seen = observations["Srobot1"]
    assert seen["goal"] == pytest.approx([8 / 9, 0.0, -1.0], abs=1e-6)
    assert 0.0 <= seen["scan"].min() <= seen["scan"].max() <= 1.0
    assert np.hypot(*seen["way"]) == pytest.approx(1.0, abs=1e-6)
    assert seen["way"][0] < -0.2  # the door is further south than the goal
    assert np.argwhere(seen["neighbours"][0]).tolist() == [[16, 17]]  # right of it, 0.7 m
    space = env.action_space("Srobot1")
    assert (space.low.tolist(), space.high.tolist()) == ([-1, -1], [1, 1])
    for _ in range(20):
        env.step({"Srobot1": [-1.0, 0.0]})
    assert env._team._arena.twists[0, 0] == pytest.approx(-0.26)


def test_precedence_tells_who_has_the_lower_number_of_the_nearest():
    env = TeamEnv(3, "doorway", neighbours=3, parts=("neighbours", "precedence"))
    starts = [(-4.0, 0.0, 0.0), (-3.0, 0.0, 0.0), (-5.0, 0.5, 0.0)]
    seen, _ = env.reset(options={"starts": starts, "goals": [(-4.0, 2.0)] * 3})
    assert seen["precedence"].tolist() == [[1, 1, 0], [-1, 1, 0], [-1, -1, 0]]


def test_former_scans_are_stacked_the_newest_last():
    env = SwarmEnv(1, "doorway", stack=3, rays=8)
    seen = env.reset(options={"starts": [(-3.0, 0.0, 0.0)], "goals": [(4.0, 0.0)]})[0]["Srobot1"]
    assert np.array_equal(seen["scan"][0], seen["scan"][2])
    for _ in range(4):
        former, seen = seen, env.step({"Srobot1": [0.26, 0.0]})[0]["Srobot1"]
    assert np.array_equal(seen["scan"][:2], former["scan"][1:])


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


def test_rewards_are_terms_with_weights_or_ones_own():
    weights = {"progress": 0.0, "way": 2.0, "time": 0.5, "closeness": 1.0, "smoothness": 0.25}
    starts = {"starts": [(-0.4, 0.0, 0.0)], "goals": [(4.0, 0.0)]}
    env = TeamEnv(1, reward=weights)
    env.reset(options=starts)
    for _ in range(12):
        _, reward, *_, info = env.step([[0.26, 0.0]])
    terms = {name: values[0] for name, values in info["terms"].items()}
    assert reward == pytest.approx(sum(terms.values()))
    assert 0.04 < terms["way"] < 0.16  # near walls a metre counts up to three times
    assert terms["time"] == pytest.approx(-0.05)
    assert (terms["closeness"] < 0.0, terms["smoothness"]) == (True, 0.0)
    own = TeamEnv(1, reward=lambda step: 7.0 * step.way_progress)
    own.reset(options=starts)
    assert own.step([[0.0, 0.0]])[1] == pytest.approx(0.0, abs=1e-9)
    for reward in ({"speed": 1.0}, {"time": "much"}, 3, lambda step: [1.0, 2.0]):
        with pytest.raises(SwarmError, match="reward"):
            _first_step(TeamEnv, reward)


def test_pydoc_describes_each_option_and_each_term_of_the_reward():
    own = set(EnvOptions.__struct_fields__) - set(PolicyConfig.__struct_fields__)
    described = {
        kind: set(re.findall(r"^ +(\w+): \S", kind.__doc__, re.MULTILINE))
        for kind in (PolicyConfig, EnvOptions, reward.StepOutcome)
    }
    assert described[PolicyConfig] == set(PolicyConfig.__struct_fields__)
    assert described[EnvOptions] == own
    assert described[reward.StepOutcome] == set(reward.StepOutcome._fields)
    rows = re.findall(r"^\| `(\w+)` \| ([\d.]+) \|", reward.__doc__, re.MULTILINE)
    assert {name: float(weight) for name, weight in rows} == reward.WEIGHTS


def _first_step(kind, reward):
    env = kind(1, reward=reward)
    env.reset()
    env.step([[0.0, 0.0]])


def test_a_curriculum_says_how_an_episode_is():
    numbers = []

    def curriculum(number, random):
        numbers.append(number)
        return {"robots": 1 + number, "people": number, "distance": (1.0, 1.5 + number)}

    env = SwarmEnv(3, curriculum=curriculum)
    for count in (1, 2, 3):
        seen, _ = env.reset(seed=count)
        assert (list(seen), env.agents) == (env.possible_agents[:count],) * 2
        goals = [np.hypot(*seen[name]["goal"]) for name in seen]
        assert all(1.0 - 1e-6 <= goal <= 0.5 + count for goal in goals)
        assert len(env._team._arena.world.walkers()) == count - 1
        env.step({})
    assert numbers == [0, 1, 2]
    team = TeamEnv(3)
    seen, _ = team.reset(seed=0, options={"robots": 2})
    assert seen["scan"].shape == (3, 360)
    assert not seen["scan"][2].any()
    assert team.step(np.zeros((3, 2)))[4]["rewards"].shape == (3,)


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


@pytest.mark.parametrize("backs", [False, True])
def test_the_shield_bends_what_would_end_at_the_post_of_a_door(backs):
    env = RobotEnv(1, "doorway", shield=True)
    starts = [(-0.6, 0.12, np.pi if backs else 0.0)]
    env.reset(options={"starts": starts, "goals": [(3.0, 0.0)]})
    furthest = -1.0
    for _ in range(200):
        *_, end, cut, info = env.step([-0.2 if backs else 0.2, 0.0])
        furthest = max(furthest, env._env._team._arena.world.poses[0, 0])
        assert not info["contact"]
        if end or cut or furthest > 0.5:
            break
    assert furthest > 0.5


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


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_in_mid_episode_goes_on_alike(copied):
    env = SwarmEnv(3, **ALL)
    env.reset(seed=1, options={"people": 1})
    actions = {name: [0.2, 0.3] for name in env.agents}
    env.step(actions)
    other = copied(env)
    for _ in range(15):
        (seen, rewards, *_), (again, also, *_) = env.step(actions), other.step(actions)
        assert rewards == also
        for name, parts in seen.items():
            assert all(np.array_equal(parts[part], again[name][part]) for part in parts)
        actions = {name: [0.2, 0.3] for name in env.agents}
    env.reset(seed=3)  # of its own
    other.reset(seed=3)
    shielded = SwarmEnv(2, shield=True)
    copied(shielded).reset(seed=0)
    shielded.reset(seed=0)
    with pytest.raises(SwarmError, match="before its first reset"):
        copied(shielded)


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


def _parts(seen):
    return seen if isinstance(seen, dict) else {"observation": seen}


@pytest.mark.parametrize("options", [{}, {**FLAT, **ALL}])
def test_worlds_in_processes_do_what_they_do_here(options):
    here = make_vec(3, robots=2, limit=2.0, **options)
    there = make_vec(3, robots=2, limit=2.0, processes=2, **options)
    try:
        seen, again = here.reset(seed=4)[0], there.reset(seed=4)[0]
        assert here.num_envs == 6
        random = np.random.default_rng(0)
        for _ in range(30):
            actions = random.uniform(-0.2, 0.2, (6, 2))
            (seen, *rest, infos), (again, *others, _) = here.step(actions), there.step(actions)
            assert here.observation_space.contains(seen)
            for part, rows in _parts(seen).items():
                assert np.array_equal(rows, _parts(again)[part])
            assert all(np.array_equal(a, b) for a, b in zip(rest, others, strict=True))
            assert set(infos) == {"reached", "contact"}
    finally:
        there.close()
    with pytest.raises(SwarmError, match="closed"):
        there.step(np.zeros((6, 2)))


@pytest.mark.parametrize("shield", [False, True])
def test_rows_begin_anew_one_by_one_as_gymnasium_says(shield):
    """The step after the last one of an episode only begins the next; or the same one does."""
    options = {"robots": 2, "limit": 0.5, "shield": shield, "observation": "flat"}
    later = make_vec(1, **options)
    at_once = make_vec(1, autoreset="same_step", **options)
    assert later.metadata["autoreset_mode"] is gymnasium.vector.AutoresetMode.NEXT_STEP
    for env in (later, at_once):
        env.reset(seed=1)
    drive = np.full((2, 2), 0.1)
    for step in range(1, 12):
        _, rewards, ends, cuts, _ = later.step(drive)
        assert not ends.any()
        assert cuts.all() == (step in (5, 11)), step
        assert (rewards == 0.0).all() == (step == 6), step
    for _ in range(5):
        seen, _, _, cuts, infos = at_once.step(drive)
    assert cuts.all()
    assert infos["_final_obs"].all()
    assert not np.array_equal(infos["final_obs"][0], seen[0])  # another goal


def test_pictures_show_the_plan():
    env = SwarmEnv(2, render_mode="rgb_array")
    with pytest.raises(SwarmError, match="call reset"):
        env.render()
    env.reset(seed=0, options={"people": 1})
    frame = env.render()
    assert (frame.shape, frame.dtype) == ((351, 640, 3), np.uint8)
    assert len(np.unique(frame.reshape(-1, 3), axis=0)) > 4
    assert env.metadata["render_fps"] == 30
    assert make_vec(1).render() is None
    with pytest.raises(SwarmError, match="screen"):
        SwarmEnv(2, render_mode="human").reset()


WRONG = {
    "robots": [0, 2.5, "two", True, 500],
    "limit": [0.0, "long", float("nan")],
    "world": ["no_such", 3],
    "robot": ["no_such"],
    "rays": [0, 1000],
    "parts": [(), ("scan", "scan"), ("smell",)],
    "observation": ["image"],
    "ticks": [0],
    "shield": ["yes"],
    "curriculum": [
        3,
        lambda number: {},
        lambda number, random: {"robot": 1},
        lambda number, random: 3,
    ],
    "reward": [3, {"joy": 1.0}, lambda: 0.0],
    "render_mode": ["ansi"],
    "limits": [5.0],
}
WALL = {"starts": [(0.0, 2.0, 0.0), (3.0, 0.0, 0.0)]}
ON_EACH_OTHER = {"starts": [(3.0, 0.0, 0.0), (3.0, 0.1, 0.0)]}
RESETS = {
    "seeds": [{"seed": -1}, {"seed": "one"}, {"seed": 1.5}],
    "options": [
        {"options": each}
        for each in (
            3, {"start": []}, {"starts": [[0.0, 0.0]]}, {"goals": [[0.0, 0.0, 0.0]] * 2},
            {"starts": [(0.0, float("nan"), 0.0)] * 2}, {"robots": 3}, {"people": -1},
            {"distance": (2.0, 1.0)}, {"distance": (40.0, 50.0)}, {"goals": [(0.0, 2.0), (3.0, 0)]},
            WALL, ON_EACH_OTHER,
        )
    ],
}  # fmt: skip


def test_what_makes_no_sense_is_refused_in_words():
    for name, values in WRONG.items():
        for value in values:
            with pytest.raises(SwarmError):
                SwarmEnv(**{name: value}).reset()
    env = SwarmEnv(2)
    for call in (lambda: env.step({}), lambda: env.action_space("Srobot3"), env._team.frame):
        with pytest.raises(SwarmError):
            call()
    for choice in RESETS.values():
        for arguments in choice:
            with pytest.raises(SwarmError):
                env.reset(**arguments)
    env.reset(seed=0)
    still = np.zeros(2)
    for actions in (
        {"Srobot9": still}, {"Srobot1": None}, {"Srobot1": [1.0]}, {"Srobot1": np.zeros(4)},
        {"Srobot1": still, "Srobot2": [np.nan, 0.0]}, {"Srobot1": "fast"},
    ):  # fmt: skip
        with pytest.raises(SwarmError):
            env.step(actions)
    assert set(env.step({"Srobot1": still})[0]) == {"Srobot1", "Srobot2"}
    team = TeamEnv(3)
    team.reset(seed=0)
    with pytest.raises(SwarmError, match="a row for each robot"):
        team.step(np.zeros((2, 2)))
    for arguments in ({"n": 0}, {"n": 1, "processes": 2}, {"n": 1, "autoreset": "never"}):
        with pytest.raises(SwarmError):
            make_vec(**arguments)
    rows = make_vec(2, curriculum=lambda number, random: {"robots": 1}, robots=2)
    for call in (lambda: rows.step(np.zeros((4, 2))), rows.reset, lambda: rows.reset(seed=[1])):
        with pytest.raises(SwarmError):
            call()


def test_a_team_takes_numbers_of_any_kind():
    rewards = []
    for kind in (np.float32, object, str):
        env = TeamEnv(2, "hall_12")
        env.reset(seed=1)
        rewards.append(env.step(np.full((2, 2), 0.25).astype(kind))[1])
    assert rewards[0] == rewards[1] == rewards[2]
