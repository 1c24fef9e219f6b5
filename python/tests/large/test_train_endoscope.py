# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The baseline of python/examples, for a few steps, with stable-baselines3."""

import importlib.util
import pathlib

import numpy
import pytest

import pliant
import pliant.gym

stable_baselines3 = pytest.importorskip("stable_baselines3")
torch = pytest.importorskip("torch")
EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "examples/train_endoscope.py"


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("train_endoscope", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def lumen():
    return pliant.gym.find_lumen(pliant.make_phantom("airway", (96, 96, 96)))


def test_stable_baselines_checker_passes(lumen):
    from stable_baselines3.common.env_checker import check_env

    check_env(pliant.gym.EndoscopeEnv(lumen, ("rgb", "state", "guide")), warn=False)


def test_the_baseline_trains_flies_and_is_reproducible(example, lumen, tmp_path):
    weights = []
    for _ in range(2):
        env = example.EndoscopeVecEnv(4, scan=lumen, targets=[0, 1], max_steps=30)
        env.seed(3)
        model = stable_baselines3.PPO("MlpPolicy", env, n_steps=40, batch_size=80, seed=3)
        model.learn(480, callback=example.Curve(example.Clock(5), tmp_path / "curve.csv"))
        weights.append(torch.nn.utils.parameters_to_vector(model.policy.parameters()).detach())
    assert torch.equal(*weights)
    rows = (tmp_path / "curve.csv").read_text().splitlines()
    assert rows[0] == "minutes,steps,ways,success,mean_reward"
    assert len(rows) == 4
    test = example.evaluate(model, lumen, [0], 2, 5)
    assert test["0"]["ways"] == 2
    assert 0 <= test["0"]["reached"] <= 2


def test_terminal_observations_are_those_before_the_next_way(example, lumen):
    env = example.EndoscopeVecEnv(2, scan=lumen, targets=[0], max_steps=5)
    env.seed(1)
    env.reset()
    for n in range(5):
        features, _, done, infos = env.step(numpy.ones((2, 4)) * [[0.5, 0, 0, 0]])
        assert done.all() == (n == 4)
    assert infos[0]["TimeLimit.truncated"]
    assert infos[0]["episode"]["l"] == 5
    assert not numpy.array_equal(infos[0]["terminal_observation"], features[0])
