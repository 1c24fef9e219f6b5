# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Environments with catheters."""

import pathlib
import pickle
import signal
import threading
import time
import warnings

import gymnasium
import numpy
import pytest
from gymnasium.utils.env_checker import check_env

import pliant
import pliant._catheter_gym
import pliant.gym

OBSERVATIONS = ("fluoro", "tracking2d", "target2d", "state", "guide")
WALLS = ("deforming", "rigid")


@pytest.fixture(scope="module")
def bend():
    return pliant.gym.find_vessel("bend")


@pytest.fixture(scope="module")
def aorta():
    return pliant.gym.find_vessel("aorta")


def inside_mm(points, nodes, cells):
    """Distance of points from a surface that faces them; negative beyond it."""
    corners = nodes[cells]
    middles = corners.mean(axis=1)
    normals = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= numpy.linalg.norm(normals, axis=1, keepdims=True)
    nearest = numpy.linalg.norm(points[:, None] - middles[None], axis=2).argmin(axis=1)
    return ((points - middles[nearest]) * normals[nearest]).sum(axis=1)


def many(vessel, threads, steps=6, count=3, seed=5, **settings):
    """All that a vector environment answers to random actions."""
    env = gymnasium.make_vec(
        "pliant/Catheter-v0", num_envs=count, vectorization_mode="vector_entry_point",
        scene=vessel, obs=OBSERVATIONS, size=(16, 12), threads=threads, **settings,
    )  # fmt: skip
    env.action_space.seed(seed)
    answers = [env.reset(seed=seed)]
    for _ in range(steps):
        actions = env.action_space.sample()
        actions[:, :, 0] = numpy.abs(actions[:, :, 0])
        answers.append(env.step(actions))
    return answers


def same(a, b) -> bool:
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    if isinstance(a, (tuple, list)):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b))
    return numpy.array_equal(a, b)


@pytest.mark.parametrize("wall", WALLS)
@pytest.mark.parametrize("steerable", [False, True])
def test_gymnasiums_checker_passes(bend, wall, steerable):
    env = gymnasium.make(
        "pliant/Catheter-v0", scene=bend, wall=wall, obs=OBSERVATIONS, size=(24, 20),
        steerable=steerable, render_mode="rgb_array", render_size=(40, 30), control_hz=15,
    )  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # ranges without bounds
        check_env(env.unwrapped)
    assert env.action_space.shape == (1, 3 if steerable else 2)
    assert env.action_space.high[0, :2].tolist() == pytest.approx([50, 3.14])
    env.reset(seed=1)
    assert env.render().shape == (30, 40, 3)


@pytest.mark.parametrize("wall", WALLS)
def test_the_same_seed_gives_the_same_bits_on_any_number_of_threads(bend, wall):
    first = many(bend, 1, wall=wall)
    assert same(first, many(bend, 2, wall=wall))
    assert same(first, many(bend, 3, wall=wall))
    assert not same(first, many(bend, 1, wall=wall, seed=6))
    hashes = first[-1][-1]["hash"]
    assert hashes.dtype == numpy.int64 and len(set(hashes.tolist())) == 3


def test_gymnasiums_own_vector_takes_the_infos(bend):
    envs = gymnasium.make_vec(
        "pliant/Catheter-v0", num_envs=2, vectorization_mode="sync", scene=bend, wall="rigid"
    )
    for seed in range(6):
        _, infos = envs.reset(seed=seed)
        assert infos["hash"].dtype == numpy.int64
        assert infos["is_success"].dtype == infos["has_left"].dtype == bool
        assert infos["target"].dtype.kind == "i"


def test_observations_are_in_finite_boxes(bend):
    obs = ("fluoro", "tracking2d", "target2d", "state", "guide")
    env = gymnasium.make("pliant/Catheter-v0", scene=bend, wall="rigid", obs=obs, max_steps=9)
    for name, box in env.observation_space.spaces.items():
        assert numpy.isfinite(box.low).all() and numpy.isfinite(box.high).all(), name
    env.reset(seed=1)
    for _ in range(9):
        observation, *_ = env.step(env.action_space.sample())
        assert env.observation_space.contains(observation)


def test_a_vectors_catheter_is_the_single_one(bend):
    obs = ("fluoro", "tracking2d", "state")
    several = pliant.gym.CatheterVectorEnv(2, bend, obs, (16, 12))
    one = pliant.gym.CatheterEnv(bend, obs, (16, 12))
    observed, _ = several.reset(seed=7)
    alone, _ = one.reset(seed=8)
    rng = numpy.random.default_rng(1)
    for _ in range(6):
        assert same({k: v[1] for k, v in observed.items()}, alone)
        actions = rng.uniform(-1, 1, (2, 1, 2)) * several.single_action_space.high
        observed, rewards, *_, infos = several.step(actions)
        alone, reward, *_, info = one.step(actions[1])
        assert rewards[1] == reward
        assert infos["hash"][1] == info["hash"]


@pytest.mark.parametrize("wall", WALLS)
def test_nothing_slips_through_the_wall(aorta, wall):
    """Random actions, mostly ahead, into the arch and its arteries."""
    count = 3
    env = pliant.gym.CatheterVectorEnv(count, aorta, ("state",), wall=wall, max_steps=1000)
    env.reset(seed=11)
    rng = numpy.random.default_rng(3)  # the seed
    radius = 0.9
    forces, moved, deepest = [], 0.0, -1.0
    for step in range(48):
        actions = rng.uniform(-1, 1, (count, 1, 2)) * [[[50, 3.14]]]
        if step % 16 < 12:
            actions[:, 0, 0] = 50
        _, _, ended, _, infos = env.step(actions)
        forces.append(infos["wall_force_n"])
        moved = max(moved, infos["displacement_max_mm"].max())
        deepest = max(deepest, infos["depth_mm"].max())
        if step % 12 == 11:
            for n in range(count):
                wire = env.arena.wire_mm(n)[:-2]  # beyond the guide
                if infos["has_left"][n] or not len(wire):
                    continue
                ghost = env.arena.ghost_mm(n)
                # Where the wall is curved, triangles' middles are a little off.
                assert inside_mm(wire, ghost, aorta.wall.ghost.cells).min() > radius - 0.5
    assert deepest < 0.1
    assert numpy.max(forces) > 0.01
    assert (moved > 0) == (wall == "deforming")


@pytest.mark.parametrize("wall", WALLS)
def test_pushing_reaches_the_end_of_a_bend(bend, wall):
    env = pliant.gym.CatheterEnv(bend, ("guide",), wall=wall, tip_bend_deg=20)
    _, info = env.reset(seed=1)
    total, before = 0.0, info["left_mm"]
    for step in range(60):
        _, reward, terminated, truncated, info = env.step(numpy.array([[50.0, 0.5]]))
        total += reward
        if terminated:
            break
    assert terminated and not truncated and info["is_success"]
    travelled = before - info["left_mm"]
    assert travelled > 80
    assert total == pytest.approx(travelled + 20, abs=step)  # less time and force


def test_leaving_the_vessel_ends_a_way(bend):
    env = pliant.gym.CatheterEnv(bend, ("guide",), wall="rigid", tip_bend_deg=20, steerable=True)
    env.reset(seed=1)
    env._flights._success_mm[:] = 0  # as if no target were there
    for _ in range(60):
        _, reward, terminated, _, info = env.step(numpy.array([[50.0, 0.5, 0.0]]))
        if terminated:
            break
    assert terminated and info["has_left"] and not info["is_success"]
    assert reward < 0


def test_the_fluoroscopy_shows_vessel_and_catheter(bend):
    env = pliant.gym.CatheterEnv(
        bend, ("fluoro", "tracking2d", "target2d"), (96, 96), wall="rigid", points=4, points_mm=6
    )
    first, _ = env.reset(seed=1)
    for _ in range(10):
        observed, *_ = env.step(numpy.array([[50.0, 0.0]]))
    darker = first["fluoro"].astype(int) - observed["fluoro"]
    assert darker.max() > 40
    # Tracked points are at dark pixels.
    view = pliant._catheter_gym._view_of(bend.wall, (96, 96), (0, 1, 0))
    pixel = view.width_mm / 96
    for x, y in observed["tracking2d"]:
        column, row = int(48 + x / pixel), int(48 - y / pixel)
        near = darker[row - 1 : row + 2, column - 1 : column + 2]
        assert near.max() > 30
    # The vessel's shadow, away from the catheter.
    columns = observed["fluoro"][80].astype(int)
    assert columns.std() > 1
    end = env.vessel.ends[0].point_mm
    assert observed["target2d"] == pytest.approx(env.arena.project(end), abs=1e-3)


def test_a_steered_tip_bends_and_stops_at_its_limit(bend):
    env = pliant.gym.CatheterEnv(bend, ("state",), wall="rigid", steerable=True, tip_bend_deg=30)
    env.reset(seed=1)
    for _ in range(4):
        observed, *_ = env.step(numpy.array([[20.0, 0, 1.5]]))
    assert observed["state"][11] == pytest.approx(numpy.radians(30))
    for _ in range(8):
        observed, *_ = env.step(numpy.array([[0.0, 0, -1.5]]))
    assert observed["state"][11] == pytest.approx(-numpy.radians(30))
    with pytest.raises(pliant.Error, match="actions: expected axes"):
        env.step(numpy.array([[20.0, 0]]))


@pytest.mark.parametrize("wall", WALLS)
def test_a_saved_state_continues_in_the_same_way(bend, wall):
    env = pliant.gym.CatheterEnv(bend, OBSERVATIONS, (16, 16), wall=wall)
    env.reset(seed=4)
    act = numpy.array([[40.0, 1.0]])
    for _ in range(8):
        env.step(act)
    state = env.save_state()
    first = [env.step(act) for _ in range(3)]
    env.reset(seed=9)
    env.load_state(state)
    assert same(first, [env.step(act) for _ in range(3)])


def test_ctrl_c_leaves_catheters_as_they_were(aorta):
    # A step of six seconds, which takes longer than a moment even on a fast machine.
    env = pliant.gym.CatheterVectorEnv(2, aorta, ("state",), control_hz=1 / 6, threads=2)
    env.reset(seed=1)
    before = [env.arena.hash(n) for n in range(2)]
    pressed = []

    def press():
        pressed.append(time.monotonic())
        signal.raise_signal(signal.SIGINT)

    timer = threading.Timer(0.2, press)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        env.step(numpy.full((2, 1, 2), 20.0))
    assert [env.arena.hash(n) for n in range(2)] == before
    timer.join()


def test_targets_masks_and_new_ways(aorta):
    env = pliant.gym.CatheterEnv(aorta, ("guide",), wall="rigid", targets=[1, 3])
    assert {env.reset(seed=n)[1]["target"] for n in range(12)} == {1, 3}
    assert env.reset(options={"target": 4})[1]["target"] == 4
    with pytest.raises(pliant.Error, match="target: expected 0 to 4"):
        pliant.gym.CatheterEnv(aorta, targets=[9])
    several = pliant.gym.CatheterVectorEnv(2, aorta, ("state",), wall="rigid", max_steps=3)
    several.reset(seed=1)
    act = numpy.zeros((2, 1, 2))
    ended = [several.step(act)[3].tolist() for _ in range(8)]
    assert ended == [[n % 4 == 2] * 2 for n in range(8)]


def test_the_aortas_ends(aorta):
    assert len(aorta.ends) == 5
    generations = sorted(end.generation for end in aorta.ends)
    assert generations[0] <= 2 and generations[-1] >= 3
    for end in aorta.ends:
        steps = numpy.linalg.norm(numpy.diff(end.path_mm, axis=0), axis=1)
        assert steps.max() < 1.2
        assert 200 < end.length_mm < 320
        inside = inside_mm(end.path_mm, aorta.wall.ghost.nodes_mm, aorta.wall.ghost.cells)
        assert inside.min() > 0.5


def test_vessels_are_pickled(bend):
    again = pickle.loads(pickle.dumps(bend))
    again.wall.check()
    assert again.entry == bend.entry
    hashes = []
    for vessel in (bend, again):
        env = pliant.gym.CatheterEnv(vessel, ("state",))
        env.reset(seed=1)
        hashes.append(env.step(numpy.array([[50.0, 1.0]]))[-1]["hash"])
    assert hashes[0] == hashes[1]


def test_vessels_of_files_walls_and_scans(tmp_path, bend):
    bend.wall.ghost.save(tmp_path / "lumen.vtp")
    from_surface = pliant.gym.find_vessel(tmp_path / "lumen.vtp")
    assert len(from_surface.ends) == 1
    of_wall = pliant.gym.find_vessel(bend.wall, entry=1)
    assert of_wall.entry[0] != bend.entry[0]
    cuts = pliant.ends_of(pliant.phantom_centreline("bend"), 0.5)
    from_scan = pliant.gym.find_vessel(
        bend.scan, ends=cuts, seed_mm=(0, 0, 30), window_hu=(200, 400)
    )
    assert from_scan.scan is bend.scan
    assert from_scan.ends[0].length_mm == pytest.approx(bend.ends[0].length_mm, rel=0.15)
    scenes = pathlib.Path(__file__).resolve().parents[2] / "scenes"
    env = gymnasium.make("pliant/Catheter-v0", scene=scenes / "vessel_phantom.toml", wall="rigid")
    env.reset(seed=1)
    assert env.unwrapped.vessel.settings["length_mm"] == 160
    with pytest.raises(pliant.Error, match="seed_mm: expected"):
        pliant.gym.find_vessel(bend.scan)
    with pytest.raises(pliant.Error, match="entry: expected 0 to 1"):
        pliant.gym.find_vessel(bend.wall, entry=7)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"obs": ("smell",)}, "obs: expected"),
        ({"wall": "soft"}, "wall: expected one of deforming, rigid"),
        ({"reward": "much"}, "reward: expected"),
        ({"control_hz": 0}, "control_hz: expected"),
        ({"points": 0}, "points: expected"),
        ({"colour_of_the_sky": 1}, "colour_of_the_sky"),
    ],
)
def test_bad_arguments_are_named(bend, arguments, message):
    with pytest.raises(pliant.Error, match=message):
        pliant.gym.CatheterEnv(bend, **arguments)
