# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Sequences with scene flow: consistent with themselves, and the same bytes from the same seed."""

import json
import zlib

import numpy
import pytest

import pliant
from pliant import scene_flow
from pliant._lumen_tree import find_lumen_ends

SIZE = (48, 36)


@pytest.fixture(scope="module")
def scan() -> pliant.Volume:
    return pliant.make_phantom("airway", (96, 96, 96))


@pytest.fixture(scope="module")
def ends(scan):
    return find_lumen_ends(scan, pliant.find_endoscope(scan).eye_mm)


def sequence(scan, ends, seed=3, frames=16, **more):
    return scene_flow.EndoscopeSequence(scan, seed, frames, SIZE, ends=ends, **more)


def pixels(points, camera, name):
    """Pixels of points (n, 3), LPS, by the camera's definition."""
    world = numpy.array(camera[name])
    x, y, z = ((points - world[:3, 3]) @ world[:3, :3]).T
    slope = numpy.tan(numpy.radians(camera["field_of_view_deg"]) / 2)
    u, v = x / z / slope, y / z / slope
    bent = numpy.hypot(u, v)
    low, high = numpy.zeros_like(bent), bent.copy()
    for _ in range(60):
        r = (low + high) / 2
        is_low = r * (1 + camera["barrel_distortion"] * r * r) < bent
        low, high = numpy.where(is_low, r, low), numpy.where(is_low, high, r)
    share = low / numpy.maximum(bent, 1e-12)
    half = SIZE[1] / 2
    return numpy.stack([SIZE[0] / 2 + half * share * u, half + half * share * v], axis=1), z


def points(frame):
    """Points (n, 3) that the pixels with depth show."""
    y, x = numpy.nonzero(frame.depth_mm)
    half = SIZE[1] / 2
    u, v = (x + 0.5 - SIZE[0] / 2) / half, (y + 0.5 - half) / half
    slope = numpy.tan(numpy.radians(frame.camera["field_of_view_deg"]) / 2)
    scale = slope * (1 + frame.camera["barrel_distortion"] * (u * u + v * v))
    depth = frame.depth_mm[y, x].astype(float)
    local = depth[:, None] * numpy.stack([scale * u, scale * v, numpy.ones_like(u)], axis=1)
    world = frame.camera["world_from_camera"]
    return local @ world[:3, :3].T + world[:3, 3], y, x


@pytest.mark.parametrize("wall", ["deforming", "rigid"])
def test_depth_flow_and_cameras_agree(scan, ends, wall):
    moved = hidden = 0
    push_mm = 3.0 if wall == "deforming" else 0.0
    frames = list(sequence(scan, ends, wall=wall, push_mm=push_mm))
    assert len(frames) == 16
    for frame, after in zip(frames, frames[1:]):
        numpy.testing.assert_array_equal(
            frame.camera["next_world_from_camera"], after.camera["world_from_camera"]
        )
        seen, y, x = points(frame)
        numpy.testing.assert_array_equal(frame.visibility == 0, frame.depth_mm == 0)
        flow, motion = frame.flow[y, x], frame.scene_flow_mm[y, x].astype(float)
        target, z = pixels(seen + motion, frame.camera, "next_world_from_camera")
        ahead = z > 1
        expected = (target - numpy.stack([x, y], axis=1) - 0.5)[ahead]
        near = numpy.abs(expected).max(axis=1) < 100
        assert numpy.abs(expected - flow[ahead])[near].max() < 0.01
        # Visible tissue is at its depth in the next picture.
        visibility = frame.visibility[y, x]
        is_seen = visibility == 1
        i, j = target[is_seen].astype(int).clip(0, numpy.array(SIZE) - 1).T
        there = after.depth_mm[j, i]
        assert numpy.median(numpy.abs(there - z[is_seen])) < 0.5
        moved += (numpy.linalg.norm(motion, axis=1) > 0.1).sum()
        hidden += (visibility == 2).sum()
        assert numpy.abs(motion).max() < 1e-6 or wall == "deforming"
    assert (moved > 200) == (wall == "deforming")
    assert hidden > 0


def test_normals_are_those_of_the_depth(scan, ends):
    (frame,) = sequence(scan, ends, frames=1)
    length = numpy.linalg.norm(frame.normals, axis=2)
    numpy.testing.assert_allclose(length[frame.depth_mm > 0], 1, atol=1e-5)
    assert (length[frame.depth_mm == 0] == 0).all()
    _, y, x = points(frame)
    half = SIZE[1] / 2
    u, v = (x + 0.5 - SIZE[0] / 2) / half, (y + 0.5 - half) / half
    ray = numpy.stack([u, v, numpy.full_like(u, 1.2)], axis=1)
    assert ((frame.normals[y, x] * ray).sum(axis=1) < 0.05).all()


def test_labels_are_of_the_tissue_behind_the_wall(scan, ends):
    grid = {
        "spacing_mm": scan.spacing_mm,
        "origin_mm": scan.origin_mm,
        "direction": numpy.array(scan.direction),
    }
    k = numpy.arange(scan.array.shape[0])[:, None, None]
    values = numpy.where(scan.array > -500, numpy.where(k < 60, 2, 3), 0).astype(numpy.int16)
    frames = list(sequence(scan, ends, labels=pliant.Volume(values, **grid)))
    found = numpy.concatenate([f.labels[f.depth_mm > 0] for f in frames])
    assert (found > 0).mean() > 0.97
    assert set(numpy.unique(found)) >= {2, 3}


def test_the_same_seed_gives_the_same_bytes(scan, ends, tmp_path):
    for name, threads in (("a", 1), ("b", 2)):
        scene_flow.write_sequence(tmp_path / name, sequence(scan, ends, threads=threads))
    scene_flow.write_sequence(tmp_path / "c", sequence(scan, ends, seed=4))
    files = sorted(p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*.*"))
    assert len(files) == 6 * 16 + 1
    for file in files:
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()
    flow = "flow/000005.flo"
    assert (tmp_path / "a" / flow).read_bytes() != (tmp_path / "c" / flow).read_bytes()


def read_picture(path):
    """Pixels of a PNG without filters."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width, height, depth = (
        int.from_bytes(data[16:20]), int.from_bytes(data[20:24]), data[24]
    )  # fmt: skip
    length = int.from_bytes(data[33:37])
    raw = numpy.frombuffer(zlib.decompress(data[41 : 41 + length]), numpy.uint8)
    rows = raw.reshape(height, -1)
    assert (rows[:, 0] == 0).all()
    values = rows[:, 1:].copy().view(">u2" if depth == 16 else "u1")
    return values.reshape(height, width, -1)


def test_files_hold_the_frames(scan, ends, tmp_path):
    made = sequence(scan, ends, frames=3)
    scene_flow.write_sequence(tmp_path, made)
    for frame in made:
        name = f"{frame.number:06d}"
        assert numpy.array_equal(read_picture(tmp_path / f"rgb/{name}.png"), frame.rgb)
        depth = read_picture(tmp_path / f"depth/{name}.png")[..., 0] / 100
        assert numpy.abs(depth - frame.depth_mm).max() <= 0.0051
        assert numpy.array_equal(scene_flow.read_flow(tmp_path / f"flow/{name}.flo"), frame.flow)
        visibility = read_picture(tmp_path / f"visibility/{name}.png")[..., 0]
        assert numpy.array_equal(visibility, frame.visibility)
        motion = numpy.load(tmp_path / f"scene_flow/{name}.npy")
        assert numpy.array_equal(motion, frame.scene_flow_mm)
    cameras = json.loads((tmp_path / "cameras.json").read_text())
    assert len(cameras["frames"]) == 3
    assert cameras["seed"] == 3


def test_bad_arguments_are_named(scan, ends, tmp_path):
    with pytest.raises(pliant.Error, match="frames: expected"):
        sequence(scan, ends, frames=0)
    with pytest.raises(pliant.Error, match="ends: expected"):
        sequence(scan, [])
    with pytest.raises(pliant.Error, match="values: expected uint8 or uint16"):
        scene_flow.write_picture(tmp_path / "a.png", numpy.zeros((2, 2)))
    (tmp_path / "a.flo").write_bytes(b"PIEH")
    with pytest.raises(pliant.Error, match="expected a .flo file"):
        scene_flow.read_flow(tmp_path / "a.flo")
