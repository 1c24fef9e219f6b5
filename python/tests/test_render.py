# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Pictures, rays and paths, against formulas and against each other."""

import copy
import gc
import pickle
import struct
import zlib

import numpy
import pytest

import pliant

POINT = (-23, -3, 1)


def tube(radius_mm=6.0, size=48, spacing=1.0):
    """Air in a tube along z, in tissue; values rise by 100 HU/mm across the wall."""
    centre = (size - 1) * spacing / 2
    j, i = numpy.meshgrid(*(numpy.arange(size) * spacing - centre,) * 2, indexing="ij")
    section = numpy.clip(100 * (numpy.hypot(i, j) - radius_mm) - 500, -1000, 100)
    return pliant.Volume(
        numpy.repeat(section[None], size, axis=0).astype(numpy.float32),
        (spacing,) * 3,
        (-centre,) * 3,
    )


def test_defaults_are_those_of_the_header():
    endoscope = pliant.Endoscope()
    assert endoscope.field_of_view_deg == 80
    assert endoscope.surface == (222, 150, 134)
    assert endoscope.polarity == "rising"
    assert pliant.Fluoroscopy().exposure_water_mm is None
    assert repr(endoscope) == "Endoscope()"
    assert repr(pliant.Section(orientation="coronal")) == "Section(orientation='coronal')"


def test_values_are_checked_and_copied():
    endoscope = pliant.Endoscope(eye_mm=numpy.array([1, 2, 3]), style="real", fog=(1, 2, 3))
    for other in (copy.deepcopy(endoscope), pickle.loads(pickle.dumps(endoscope))):
        assert other == endoscope
        other.iso_hu = -300
        assert other != endoscope
    assert endoscope.replaced(iso_hu=0).iso_hu == 0
    assert endoscope.iso_hu == -500
    for wrong, message in (
        ({"polarity": "up"}, "polarity: expected rising or falling, found up"),
        ({"fog": (0, 0, 256)}, "fog: expected three whole numbers of 0 to 255"),
        ({"eye_mm": (1, 2)}, "eye_mm: expected three numbers"),
        ({"iso_hu": "x"}, "iso_hu: expected a number, found 'x'"),
        ({"eye": (1, 2, 3)}, "eye"),
    ):
        with pytest.raises(pliant.Error, match=message) as raised:
            pliant.Endoscope(**wrong)
        assert raised.value.code == "invalid_argument"
        with pytest.raises(pliant.Error):
            endoscope.replaced(**wrong)
    with pytest.raises(pliant.Error, match="width: expected 1 to 16384, found 0"):
        pliant.view_directions(endoscope, 0, 4)


def test_directions_are_those_of_the_formula(rng):
    look, up = rng.normal(size=(2, 3))
    e = pliant.Endoscope(look=look, up=up, field_of_view_deg=70, barrel_distortion=0.2)
    width, height = 7, 5
    found = pliant.view_directions(e, width, height)
    y, x = numpy.meshgrid(numpy.arange(height) + 0.5, numpy.arange(width) + 0.5, indexing="ij")
    u, v = (x - width / 2) / (height / 2), (height / 2 - y) / (height / 2)
    scale = numpy.tan(numpy.radians(35)) * (1 + 0.2 * (u**2 + v**2))
    ahead = look / numpy.linalg.norm(look)
    right = numpy.cross(ahead, up)
    right /= numpy.linalg.norm(right)
    rays = (
        ahead
        + (scale * u)[..., None] * right
        + (scale * v)[..., None] * numpy.cross(right, ahead)
    )
    rays /= numpy.linalg.norm(rays, axis=-1, keepdims=True)
    assert found == pytest.approx(rays, abs=1e-12)


def test_rays_hit_where_the_values_cross(rng):
    scan = tube()
    caster = pliant.RayCaster(scan, threads=1)
    angle = rng.uniform(0, 2 * numpy.pi, 50)
    across = numpy.stack([numpy.cos(angle), numpy.sin(angle), 0 * angle], axis=-1)
    distances = caster.first_hits((0, 0, 0), 3 * across)
    assert distances == pytest.approx(6, abs=0.05)
    for d, t in zip(across, distances, strict=True):
        hit = caster.first_hit((0, 0, 0), d)
        assert hit.distance_mm == pytest.approx(t, abs=1e-6)
        assert hit.point_mm == pytest.approx(tuple(t * d), abs=1e-6)
        assert numpy.dot(hit.normal, d) < -0.98
    assert caster.first_hit((0, 0, 0), (0, 0, 1)) is None
    assert numpy.isinf(caster.first_hits((0, 0, 0), [[[0, 0, 1]]])).tolist() == [[True]]
    assert caster.first_hits((0, 0, 0), numpy.zeros((0, 3))).shape == (0,)
    nearest = caster.nearest_surface((4, 0, 0), within_mm=3)
    assert nearest.distance_mm == pytest.approx(2, abs=0.05)
    assert caster.nearest_surface((0, 0, 0), within_mm=3) is None
    with pytest.raises(pliant.Error, match=r"directions: expected axes \(..., 3\)"):
        caster.first_hits((0, 0, 0), [[1, 2]])


def test_depth_and_picture_agree():
    scan = tube()
    caster = pliant.RayCaster(scan, threads=2)
    e = pliant.Endoscope(look=(0.3, 0, 1), fog=(0, 255, 0))
    picture = caster.endoscope_view(e, 96, 64)
    colour, depth, normals, points = caster.endoscope_frame(e, 96, 64)
    assert (colour == picture).all()
    assert picture.shape == (64, 96, 3)
    assert picture.dtype == numpy.uint8
    assert depth.dtype == numpy.float32
    rays = pliant.view_directions(e, 96, 64)
    distance = caster.first_hits((0, 0, 0), rays)
    away = numpy.isinf(distance)
    along = distance[~away] * (rays[~away] @ (e.look / numpy.linalg.norm(e.look)))
    assert depth[~away] == pytest.approx(along, rel=1e-5)
    assert (depth[away] == 0).all()
    assert points[~away] == pytest.approx(distance[~away][:, None] * rays[~away], abs=1e-6)
    assert numpy.isinf(points[away]).all()
    assert numpy.linalg.norm(normals[~away], axis=-1) == pytest.approx(1, abs=1e-5)
    seen = pliant.project(e, 96, 64, points[~away])
    assert seen == pytest.approx(numpy.argwhere(~away)[:, ::-1] + 0.5, abs=1e-6)
    assert numpy.isnan(pliant.project(e, 96, 64, (-3.0, 0, -10))).all()
    # An infinite cylinder; its ends are open at +-23.5 mm.
    expected = 6 / numpy.hypot(rays[..., 0], rays[..., 1])
    inside = numpy.abs(expected * rays[..., 2]) < 23
    assert inside.sum() > 1000
    assert distance[inside] == pytest.approx(expected[inside], rel=0.02)
    # Away from edges, that are averaged.
    flat = away.copy()
    flat[1:] &= away[:-1]
    flat[:-1] &= away[1:]
    flat[:, 1:] &= away[:, :-1]
    flat[:, :-1] &= away[:, 1:]
    assert flat.any()
    assert (picture[flat] == (0, 255, 0)).all()
    assert (picture[~away][:, 0] > picture[~away][:, 1] * 0.9).mean() > 0.9
    hit = caster.pick(e, 96, 64, 20.5, 30.5)
    assert hit.distance_mm == pytest.approx(distance[30, 20], abs=1e-4)
    assert (picture == pliant.RayCaster(scan, threads=1).endoscope_view(e, 96, 64)).all()


@pytest.mark.parametrize("style", ["plain", "real"])
def test_a_caster_follows_its_tissue(airway, style):
    tissue = pliant.make_chainmail(airway, threads=1)
    e = pliant.aim_endoscope(airway, POINT, (4, 0, 0))
    e.style = style
    caster = pliant.RayCaster(tissue, threads=1)
    before = caster.endoscope_view(e, 64, 64)
    assert (before == pliant.RayCaster(airway).endoscope_view(e, 64, 64)).all()
    tissue.push(POINT, (4, 0, 0), sphere_radius_mm=4)
    pushed = caster.endoscope_view(e, 64, 64)
    assert (pushed != before).sum() > 100
    made_now = pliant.RayCaster(tissue).endoscope_view(e, 64, 64)
    assert (pushed == made_now).all()
    depth = pliant.RayCaster(tissue.volume()).endoscope_frame(e, 64, 64)[1]
    assert (caster.endoscope_frame(e, 64, 64)[1] == depth).all()
    tissue.undo()
    assert (caster.endoscope_view(e, 64, 64) == before).all()
    # The caster keeps its tissue.
    del tissue
    gc.collect()
    assert (caster.endoscope_view(e, 64, 64) == before).all()
    assert caster.scan.model == "chainmail"


def test_a_section_shows_the_values():
    values = numpy.linspace(-1000, 1000, 20 * 30 * 40).reshape(20, 30, 40).astype(numpy.float32)
    scan = pliant.Volume(values, (1, 1, 1), (0, 0, 0))
    section = pliant.Section(
        point_mm=(19.5, 14.5, 7), window_hu=2000, level_hu=0, width_mm=40, crosshair=False
    )
    picture = pliant.section_view(scan, section, 40, 30)
    grey = 255 * (values[7] + 1000) / 2000
    assert (picture[..., 0] == picture[..., 1]).all()
    assert agrees(picture, grey)
    lines = pliant.section_view(scan, section.replaced(crosshair=True), 40, 30)
    assert (lines != picture).any()
    frontal = section.replaced(orientation="coronal", point_mm=(19.5, 14.5, 9.5))
    coronal = pliant.section_view(scan, frontal, 40, 20)
    expected = 255 * ((values[::-1, 14] + values[::-1, 15]) / 2 + 1000) / 2000
    assert agrees(coronal, expected)


def agrees(picture, grey):
    """Whether a section shows these values, but for its letters."""
    return (numpy.abs(picture[..., 0] - grey) < 1.01).mean() > 0.75


def test_four_up_holds_the_endoscope_s_picture(airway):
    e = pliant.find_endoscope(airway)
    picture = pliant.four_up_view(airway, e, width=256, height=256)
    alone = pliant.RayCaster(airway).endoscope_view(e, 127, 127)  # a line between the panels
    assert picture.shape == (256, 256, 3)
    assert (picture[:127, :127] == alone).mean() > 0.8  # but for letters and the caption
    named = pliant.four_up_view(airway, e, caption="airway", width=256, height=256)
    assert (named != picture).sum() > 20
    section = pliant.Section(point_mm=e.eye_mm)
    tool = pliant.outline_tool(picture, airway, e, section, e.eye_mm, 5)
    assert 20 < (tool != picture).any(axis=-1).sum() < 5000
    both = pliant.side_by_side(picture, tool)
    assert both.shape[1] > 2 * 256 - 1
    assert (both[:, :256] == picture).all()
    with pytest.raises(pliant.Error, match="right: expected a height of 256, found 127"):
        pliant.side_by_side(picture, alone)


def test_water_lengths_are_chords_of_a_box():
    values = numpy.full((21, 21, 21), -1000, numpy.int16)
    values[5:16, 5:16, 5:16] = 0
    scan = pliant.Volume(values, (2, 2, 2), (-20, -20, -20))
    f = pliant.Fluoroscopy(width_mm=1, source_mm=1e5, border_mm=0)
    lengths = pliant.water_lengths_mm(scan, f, 3, 3)
    # Ten cells of water and half of one on either side.
    assert lengths.shape == (3, 3)
    assert lengths == pytest.approx(22, rel=1e-3)
    assert pliant.water_lengths_mm(scan, f.replaced(centre_mm=(30, 0, 0)), 1, 1)[0, 0] == 0
    wide = f.replaced(width_mm=60, exposure_water_mm=10.0)
    lengths = pliant.water_lengths_mm(scan, wide, 64, 48)
    picture = pliant.fluoroscopy_view(scan, wide, 64, 48)
    p, p0 = 0.02 * lengths, 0.02 * 10
    grey = 255 / (1 + 0.55 / 0.45 * numpy.exp(p - p0))
    assert picture[..., 0].astype(float) == pytest.approx(grey, abs=1.01)
    noisy = wide.replaced(noise=1.0, seed=3)
    assert (pliant.fluoroscopy_view(scan, noisy, 64, 48) != picture).any()
    again = pliant.fluoroscopy_view(scan, noisy, 64, 48)
    assert (pliant.fluoroscopy_view(scan, noisy, 64, 48) == again).all()


def test_a_path_stays_in_the_middle():
    scan = tube()
    path = pliant.find_lumen_path(scan, (2, 1, -20), (-1, 3, 20))
    middle = path.points_mm[3:-3]
    assert len(middle) > 10
    assert numpy.hypot(middle[:, 0], middle[:, 1]).max() < 1
    assert path.radius_mm[3:-3] == pytest.approx(6, abs=0.7)
    assert path.length_mm == pytest.approx(
        numpy.linalg.norm(numpy.diff(path.points_mm, axis=0), axis=1).sum(), rel=1e-6
    )
    assert numpy.linalg.norm(numpy.diff(path.points_mm, axis=0), axis=1).max() <= 2.01
    points = path.points_mm
    del path
    gc.collect()
    assert len(points) > 16
    with pytest.raises(pliant.Error, match="from"):
        pliant.find_lumen_path(scan, (15, 15, 0), (0, 0, 0))
    with pytest.raises(pliant.Error, match="scan: expected a Volume or a Tissue"):
        pliant.find_lumen_path(numpy.zeros((3, 3, 3)), (15, 15, 0), (0, 0, 0))


def test_views_are_found(airway):
    e = pliant.find_endoscope(airway)
    ijk = numpy.rint(airway.voxel_from_world(e.eye_mm)).astype(int)
    assert airway.array[tuple(ijk[::-1])] < -500
    look = pliant.find_look(airway, e.eye_mm)
    assert numpy.linalg.norm(look) == pytest.approx(1)
    solid = pliant.Volume(numpy.zeros((8, 8, 8), numpy.int16))
    assert pliant.find_endoscope(solid) is None
    assert pliant.find_look(airway, (1e4, 0, 0)) is None
    whole = pliant.view_of_whole(airway)
    assert not airway_box(airway, whole.eye_mm)
    transfer = pliant.TransferFunction()
    blended = pliant.RayCaster(airway).blended_view(whole, transfer, 32, 32)
    assert blended.shape == (32, 32, 3)
    assert blended.std() > 1


def airway_box(scan, point):
    ijk = numpy.array(scan.voxel_from_world(point))
    return ((ijk >= 0) & (ijk < scan.size)).all()


def test_a_picture_is_written(tmp_path, rng):
    picture = rng.integers(0, 256, (5, 7, 3)).astype(numpy.uint8)
    pliant.write_png(tmp_path / "a.png", picture)
    data = (tmp_path / "a.png").read_bytes()
    assert struct.unpack(">II", data[16:24]) == (7, 5)
    start = data.index(b"IDAT")
    length = struct.unpack(">I", data[start - 4 : start])[0]
    rows = zlib.decompress(data[start + 4 : start + 4 + length])
    assert len(rows) == 5 * (7 * 3 + 1)
    with pytest.raises(pliant.Error, match="picture: expected axes"):
        pliant.write_png(tmp_path / "b.png", picture[..., 0])
    with pytest.raises(pliant.Error, match="picture"):
        pliant.write_png(tmp_path / "b.png", picture.astype(float))
    assert not (tmp_path / "b.png").exists()
