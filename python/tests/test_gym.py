# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Environments in a lumen."""

import pathlib
import re
import subprocess
import sys
import warnings

import gymnasium
import numpy
import pytest
from gymnasium.utils.env_checker import check_env

import pliant
import pliant.gym


@pytest.fixture(scope="module")
def lumen() -> pliant.gym.Lumen:
    """The phantom's airway, coarse, for speed."""
    return pliant.gym.find_lumen(pliant.make_phantom("airway", (96, 96, 96)))


def flight(lumen, threads, steps=12, count=3, seed=5, **settings):
    """All that a vector environment answers to random actions."""
    env = gymnasium.make_vec(
        "pliant/Endoscope-v0", num_envs=count, vectorization_mode="vector_entry_point",
        scan=lumen, obs=pliant.gym.OBSERVATIONS, size=(16, 12), threads=threads, **settings,
    )  # fmt: skip
    env.action_space.seed(seed)
    answers = [env.reset(seed=seed)]
    for _ in range(steps):
        answers.append(env.step(env.action_space.sample()))
    hashes = [env.unwrapped.arena.hash(n) for n in range(count)]
    return answers, hashes


def same(a, b) -> bool:
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    if isinstance(a, (tuple, list)):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b))
    return numpy.array_equal(a, b)


def test_importing_pliant_imports_no_gymnasium():
    code = "import pliant, sys; assert 'gymnasium' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    "walls", [{"wall": "deforming"}, {"wall": "rigid"}, {"model": "elastic", "radius_mm": 2.5}]
)
def test_gymnasiums_checker_passes(lumen, walls):
    env = gymnasium.make(
        "pliant/Endoscope-v0", scan=lumen, obs=pliant.gym.OBSERVATIONS,
        size=(24, 20), render_mode="rgb_array", render_size=(40, 30), **walls,
    )  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # actions in units
        check_env(env.unwrapped)
    for name, box in env.observation_space.spaces.items():
        assert numpy.isfinite(box.low).all() and numpy.isfinite(box.high).all(), name
    env.reset(seed=1)
    assert env.render().shape == (30, 40, 3)
    assert env.render().std() > 5


def test_the_documents_examples_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    document = pathlib.Path(__file__).resolve().parents[2] / "docs/howto/gym.md"
    names: dict[str, object] = {}
    blocks = re.findall(r"^```python\n(.*?)^```", document.read_text(), re.M | re.S)
    for block in blocks:
        exec(compile(block, document.name, "exec"), names)
    assert names["picture"].shape == (256, 256, 3)
    assert (tmp_path / "airway_1/flow/000002.flo").exists()


def test_gymnasium_imports_the_module_of_a_name():
    code = "import gymnasium; gymnasium.make('pliant.gym:pliant/Endoscope-v0', obs=['smell'])"
    made = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "obs: expected some of rgb" in made.stderr  # it got as far as that


def test_the_same_seed_gives_the_same_bits_on_any_number_of_threads(lumen):
    first = flight(lumen, 1)
    assert same(first, flight(lumen, 2))
    assert same(first, flight(lumen, 3))
    assert not same(first, flight(lumen, 1, seed=6))


def test_a_vectors_endoscope_is_the_single_one(lumen):
    obs = ("depth", "state", "guide")
    many = pliant.gym.EndoscopeVectorEnv(2, lumen, obs, (16, 12))
    one = pliant.gym.EndoscopeEnv(lumen, obs, (16, 12))
    observed, _ = many.reset(seed=7)
    alone, _ = one.reset(seed=8)
    rng = numpy.random.default_rng(1)
    for _ in range(10):
        assert same({k: v[1] for k, v in observed.items()}, alone)
        actions = rng.uniform(-1, 1, (2, 4)) * many.single_action_space.high
        observed, rewards, *_ = many.step(actions)
        alone, reward, *_ = one.step(actions[1])
        assert rewards[1] == reward


def test_the_force_of_elastic_walls_is_that_of_the_tissue(lumen):
    env = pliant.gym.EndoscopeEnv(
        lumen, ("state",), (4, 4), model="elastic", radius_mm=3.0, poisson_ratio=0.4, control_hz=10
    )
    env.reset(seed=4)
    eye, look, up = env.arena.states[0, :3], (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    env.arena.place(0, eye, look, up)
    tissue = pliant.make_elastic(lumen.scan, poisson_ratio=0.4)
    for _ in range(4):
        observation, _, _, _, info = env.step([20, 0, 0, 0])
        eye = tissue.slide(eye, (0, 2, 0), 3.0, lumen.iso_hu).end_mm
        tissue.advance(max_steps=1)
    force = numpy.array(tissue.force_n(1))
    assert numpy.linalg.norm(force) > 1e-3
    assert observation["state"][9:12] == pytest.approx(force, rel=1e-6)
    assert info["wall_force_n"] == pytest.approx(numpy.linalg.norm(force))
    assert info["is_touching"]
    with pytest.raises(pliant.Error, match="offset"):
        pliant.gym.EndoscopeEnv(lumen, model="elastic", offset=0.2)
    with pytest.raises(pliant.Error, match="model: expected chainmail or elastic, found foam"):
        pliant.gym.EndoscopeEnv(lumen, model="foam")


def test_ends_of_the_phantoms_airway(lumen):
    generations = [end.generation for end in lumen.ends]
    assert 10 <= len(generations) <= 14
    assert generations.count(5) == 2  # right lower lobe
    for end in lumen.ends:
        assert len(end.branches_mm) == end.generation
        steps = numpy.linalg.norm(numpy.diff(end.path_mm, axis=0), axis=1)
        assert steps.max() < 1.2
        values = [
            lumen.scan.array[tuple(numpy.round(lumen.scan.voxel_from_world(p)).astype(int)[::-1])]
            for p in end.path_mm
        ]
        assert max(values) < 0
    train, test = lumen.targets(split="train"), lumen.targets(split="test")
    assert sorted(train + test) == lumen.targets()
    assert not set(train) & set(test)
    with pytest.raises(pliant.Error, match="generation: expected"):
        lumen.targets(generation=9)


def guided(guide: numpy.ndarray) -> numpy.ndarray:
    """Turns to the next point of the path, and goes there."""
    ahead = guide[:, :3] / numpy.linalg.norm(guide[:, :3], axis=1, keepdims=True)
    actions = numpy.zeros((len(guide), 4))
    actions[:, 3] = numpy.clip(4 * ahead[:, 0], -1.5, 1.5)
    actions[:, 2] = numpy.clip(-4 * ahead[:, 1], -1.5, 1.5)
    actions[:, 0] = 20 * numpy.maximum(ahead[:, 2], 0) ** 2
    return actions


@pytest.mark.parametrize("wall", ["deforming", "rigid"])
def test_following_the_guide_reaches_the_targets(lumen, wall):
    count = len(lumen.ends)
    env = pliant.gym.EndoscopeVectorEnv(
        count, lumen, ("guide",), (4, 4), wall=wall, max_steps=400, radius_mm=1.0
    )
    env.reset(seed=3)
    for n in range(count):
        env._flights.reset(n, numpy.random.default_rng(n), {"target": n})
    env._flights.look()
    observed = env._flights.observation()
    reached, total = numpy.zeros(count, bool), numpy.zeros(count)
    for _ in range(300):
        observed, rewards, terminated, _, infos = env.step(guided(observed["guide"]))
        total += rewards * ~reached
        reached |= terminated
        if reached.all():
            break
        assert numpy.array_equal(infos["is_success"], terminated)
    assert reached.all()
    assert (total > 60).all()  # the way's length in millimetres, and more


def test_walls_give_way_or_stop_the_tip(lumen):
    for wall in ("deforming", "rigid"):
        env = pliant.gym.EndoscopeEnv(lumen, ("depth", "state"), (16, 16), wall=wall)
        _, before = env.reset(seed=2)
        moved, touched = 0.0, False
        for n in range(60):
            turn = 1.5 if n < 15 else 0.0
            _, _, _, _, info = env.step(numpy.array([15, 0, 0, turn]))
            moved = max(moved, info["displacement_max_mm"])
            touched = touched or info["wall_force_n"] > 0
        assert touched
        assert (moved > 1) == (wall == "deforming")


def test_a_saved_state_continues_in_the_same_way(lumen):
    env = pliant.gym.EndoscopeEnv(lumen, ("depth", "guide", "state"), (16, 16))
    env.reset(seed=4)
    act = numpy.array([15, 0.2, 0.4, 0.8])
    for _ in range(25):
        env.step(act)
    state = env.save_state()
    first = [env.step(act) for _ in range(5)]
    env.reset(seed=9)
    env.load_state(state)
    assert same(first, [env.step(act) for _ in range(5)])


def test_ways_begin_anew_when_they_end(lumen):
    env = pliant.gym.EndoscopeVectorEnv(2, lumen, ("guide",), (4, 4), max_steps=5)
    env.reset(seed=1)
    act = numpy.zeros((2, 4))
    ended = [env.step(act)[3].tolist() for _ in range(12)]
    assert ended == [[n % 6 == 4] * 2 for n in range(12)]
    assert gymnasium.vector.AutoresetMode.NEXT_STEP == env.metadata["autoreset_mode"]


def test_ways_begin_anew_where_a_mask_says(lumen):
    mode = gymnasium.vector.AutoresetMode.DISABLED
    env = pliant.gym.EndoscopeVectorEnv(3, lumen, ("state",), (4, 4), autoreset_mode=mode)
    first, _ = env.reset(seed=1)
    act = numpy.tile([10.0, 0, 0, 0], (3, 1))
    moved, *_ = env.step(act)
    mask = numpy.array([False, True, False])
    observed, _ = env.reset(seed=[None, 2, None], options={"reset_mask": mask})
    assert numpy.array_equal(observed["state"][1], first["state"][1])
    assert numpy.array_equal(observed["state"][~mask], moved["state"][~mask])


def test_targets_by_number(lumen):
    env = pliant.gym.EndoscopeEnv(lumen, ("guide",), (4, 4), targets=[2, 5])
    assert {env.reset(seed=n)[1]["target"] for n in range(20)} == {2, 5}
    assert env.reset(options={"target": 3})[1]["target"] == 3
    with pytest.raises(pliant.Error, match="target: expected 0 to"):
        pliant.gym.EndoscopeEnv(lumen, targets=[99])


def test_a_large_force_ends_a_way(lumen):
    env = pliant.gym.EndoscopeEnv(lumen, ("guide",), (4, 4), max_force_n=0.05)
    env.reset(seed=2)
    for n in range(80):
        _, reward, terminated, _, info = env.step(numpy.array([15, 0, 0, 1.5 if n < 15 else 0]))
        assert terminated == (info["wall_force_n"] > 0.05)
        if terminated:
            break
    assert terminated and not info["is_success"]
    assert reward < -9


def test_a_reward_of_ones_own(lumen):
    def reward(before, after, action):
        return before["left_mm"] - after["left_mm"] + float(action[0])

    env = pliant.gym.EndoscopeEnv(lumen, ("guide",), (4, 4), reward=reward)
    _, before = env.reset(seed=1)
    _, value, _, _, after = env.step(numpy.array([3.0, 0, 0, 0]))
    assert value == before["left_mm"] - after["left_mm"] + 3


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"obs": ("smell",)}, "obs: expected"),
        ({"wall": "soft"}, "wall: expected one of deforming, rigid"),
        ({"split": "half"}, "split: expected"),
        ({"reward": "much"}, "reward: expected"),
        ({"radius_mm": -1.0}, "radius_mm: expected"),
        ({"colour_of_the_sky": 1}, "colour_of_the_sky"),
    ],
)
def test_bad_arguments_are_named(lumen, arguments, message):
    with pytest.raises(pliant.Error, match=message):
        pliant.gym.EndoscopeEnv(lumen, **arguments)


def test_bad_calls_are_named(lumen):
    env = pliant.gym.EndoscopeEnv(lumen, ("guide",), (4, 4))
    with pytest.raises(pliant.Error, match="options: expected"):
        env.reset(options={"colour": 1})
    voxel = numpy.argwhere(lumen.scan.array > 0)[0][::-1]
    with pytest.raises(pliant.Error, match="eye_mm: expected a position in a lumen"):
        env.reset(options={"eye_mm": lumen.scan.world_from_voxel(voxel.tolist())})
    env.reset(seed=0)
    with pytest.raises(pliant.Error, match="actions: expected finite"):
        env.step(numpy.array([numpy.nan, 0, 0, 0]))
    with pytest.raises(pliant.Error, match="endoscope: expected 0 to 0"):
        env.arena.hash(1)


def test_a_scan_file_and_ones_own_start(tmp_path, lumen):
    lumen.scan.save(tmp_path / "airway.nrrd")
    env = gymnasium.make("pliant/Endoscope-v0", scan=tmp_path / "airway.nrrd", obs=("guide",))
    observed, info = env.reset(seed=1)
    assert info["left_mm"] > 50
    voxel = numpy.argwhere(lumen.scan.array > 0)[0][::-1]
    with pytest.raises(pliant.Error, match="start_mm: expected a position in a lumen"):
        pliant.gym.find_lumen(lumen.scan, lumen.scan.world_from_voxel(voxel.tolist()))
    with pytest.raises(pliant.Error, match="expected a lumen"):
        pliant.gym.find_lumen(pliant.Volume(numpy.zeros((8, 8, 8), numpy.int16)))
