# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Motion of the lung from its shape at two phases, or from points: the study behind `pliant morph`.

The field u(x) takes the exhaled lung to the inhaled one. Three kinds of input are compared on
landmark pairs: the outermost 30 % of the landmarks, these and the masks, and the masks alone. The
error is the mean distance [mm] of the inner 70 %. Parameters are the same for all cases.

    pip install numpy scipy
    python morph_study.py DATA             # the table of README.md
    python morph_study.py DATA --sweep     # and each parameter at 50 % and 150 %

DATA holds `4dct_caseNN_landmarks.csv`, `copd_caseNN_landmarks.csv` and
`copd_caseNN_{exhale,inhale}_mask.nii.gz`.
"""

import argparse
import gzip
import struct
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy import ndimage
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

CASES = range(1, 6)


@dataclass(frozen=True)
class Settings:
    """Parameters of all methods."""

    points_per_lung: int = 160  # of each surface
    normal_mm: float = 20.0  # distance of points whose normals differ by 1
    # Spline with sliding constraints.
    point_softness_mm: float = 1.0  # lambda of a landmark
    slide_softness_mm: tuple = (3000.0, 1000.0, 300.0, 300.0)  # lambda of a surface point, by round
    # Elastic lung in sliding contact.
    poisson: float = 0.0
    bending_mm2: float = 1000.0  # second-order modulus / shear modulus
    slide_weight: tuple = (0.003, 0.01, 0.03)  # spring / shear modulus [1/mm^2], by round
    gravity: float = 0.5  # relative growth of the dilation per standard deviation towards the back
    base: float = 0.2  # the same towards the diaphragm
    pitch: float = -0.4  # eigenstrain e_yz / linear growth
    control_mm: float = 58.0  # spacing of the control points of the cubic B-splines
    box_rest: bool = True  # rest shape scaled per axis; otherwise uniformly, by the volumes


def read_nifti(path):
    """Reads an 8-bit or 16-bit volume and its spacing [mm]."""
    data = gzip.decompress(path.read_bytes())
    dim = struct.unpack("<8h", data[40:56])[1:4]
    kind = {2: np.uint8, 4: np.int16}[struct.unpack("<h", data[70:72])[0]]
    spacing = np.array(struct.unpack("<8f", data[76:108])[1:4])
    start = int(struct.unpack("<f", data[108:112])[0])
    return np.frombuffer(data[start:], kind, count=np.prod(dim)).reshape(dim, order="F"), spacing


def split_lungs(mask, spacing):
    """Labels the lung of smaller x as 1, the other as 2.

    The mask is eroded until its two largest parts are of similar size. These grow again in the
    order of the distance from the surface.
    """
    depth = ndimage.distance_transform_edt(mask, spacing)
    for level in range(30):
        parts, count = ndimage.label(depth > level)
        sizes = np.bincount(parts.ravel(), minlength=3)[1:]
        order = np.argsort(-sizes)
        if count >= 2 and sizes[order[1]] > 0.25 * sizes[order[0]]:
            break
    seeds = sorted(order[:2] + 1, key=lambda part: ndimage.center_of_mass(parts == part)[0])
    lungs = np.zeros(mask.shape, np.uint8)
    for label, part in enumerate(seeds):
        lungs[parts == part] = label + 1
    cross = ndimage.generate_binary_structure(3, 1)
    for shell in [*range(level - 1, -1, -1), -1]:
        while True:
            spread = ndimage.maximum_filter(lungs, footprint=cross)
            new = mask & (depth > shell) & (lungs == 0) & (spread > 0)
            if not new.any():
                break
            lungs[new] = spread[new]
    return lungs


def surface(mask, spacing):
    """Points [mm] and outward normals of the mask's surface, smoothed by 3 mm."""
    smooth = ndimage.gaussian_filter(mask.astype(float), 3.0 / spacing)
    slope = np.stack(np.gradient(smooth, *spacing), -1)
    inside = smooth > 0.5
    ijk = np.argwhere(ndimage.binary_dilation(inside) & ~ndimage.binary_erosion(inside))
    at = tuple(ijk.T)
    steep = np.linalg.norm(slope[at], axis=1)
    step = (0.5 - smooth[at])[:, None] * slope[at] / np.maximum(steep, 1e-9)[:, None] ** 2
    keep = (steep > 0.02) & (np.linalg.norm(step, axis=1) < 5.0)
    return (ijk * spacing + step)[keep], (-slope[at] / np.maximum(steep, 1e-9)[:, None])[keep]


def thin(points, count):
    """Indices of about `count` points, one per cell of a cubic grid."""
    low, high = 2.0, 60.0
    for _ in range(20):
        size = (low + high) / 2
        if len(np.unique((points // size).astype(int), axis=0)) > count:
            low = size
        else:
            high = size
    _, cell = np.unique((points // high).astype(int), axis=0, return_inverse=True)
    cell = cell.ravel()
    middle = np.stack([np.bincount(cell, x) / np.bincount(cell) for x in points.T], 1)
    order = np.lexsort((np.linalg.norm(points - middle[cell], axis=1), cell))
    return order[np.r_[True, np.diff(cell[order]) > 0]]


class Lung:
    """One lung at both phases: voxels, surfaces, and the sample of the surfaces that is matched."""

    def __init__(self, lungs_from, lungs_to, label, spacing, settings):
        self.voxels_from = np.argwhere(lungs_from == label) * spacing
        self.voxels_to = np.argwhere(lungs_to == label) * spacing
        points, normals = surface(lungs_from == label, spacing)
        chosen = thin(points, settings.points_per_lung)
        self.x, self.n = points[chosen], normals[chosen]
        self.y, self.m = surface(lungs_to == label, spacing)
        self.chosen_to = thin(self.y, settings.points_per_lung)
        self.tree_to = cKDTree(np.c_[self.y, settings.normal_mm * self.m])

    def match(self, moved, normals, settings):
        """Sliding constraints n . u(x) = gap, both ways: indices of x, n, vectors to the target."""
        normals = settings.normal_mm * normals
        near = self.tree_to.query(np.c_[moved, normals])[1]
        y, m = self.y[self.chosen_to], self.m[self.chosen_to]
        back = cKDTree(np.c_[moved, normals]).query(np.c_[y, settings.normal_mm * m])[1]
        index = np.r_[np.arange(len(moved)), back]
        n = np.r_[self.m[near], m]
        return index, n, ((np.r_[self.y[near], y] - self.x[index]) * n).sum(1)


class Case:
    """Landmarks a (exhale) and b (inhale) [mm], and the two lungs if there are masks."""

    def __init__(self, folder, kind, number, settings):
        table = np.loadtxt(
            folder / f"{kind}_case{number:02d}_landmarks.csv", delimiter=",", skiprows=1
        )
        self.a, self.b = table[:, :3], table[:, 3:6]
        far = np.linalg.norm((self.a - self.a.mean(0)) / self.a.std(0), axis=1)
        order = np.argsort(-far)
        count = round(0.3 * len(far))
        self.known, self.asked = order[:count], order[count:]
        if kind != "copd":
            return
        labels = []
        for phase in ("exhale", "inhale"):
            mask, spacing = read_nifti(folder / f"copd_case{number:02d}_{phase}_mask.nii.gz")
            labels.append(split_lungs(mask[::2, ::2, ::2] > 0, 2 * spacing))
        spacing = 2 * spacing
        self.lungs = [Lung(*labels, label, spacing, settings) for label in (1, 2)]
        nearest = ndimage.distance_transform_edt(
            labels[0] == 0, spacing, return_distances=False, return_indices=True
        )
        ijk = np.clip(np.round(self.a / spacing).astype(int), 0, np.array(mask.shape) // 2 - 1)
        self.side = labels[0][tuple(nearest[:, *ijk.T])]

    def error(self, u):
        """Mean distance of the inner landmarks [mm] after the displacement u."""
        return np.linalg.norm(self.a + u - self.b, axis=1)[self.asked].mean()


class Spline:
    """Thin plate spline through linear constraints n_j . u(x_j) = g_j of softness lambda_j.

    u(x) = a + B x - sum_j c_j |x - x_j| n_j, the minimum of the integral of |grad grad u|^2
    divided by 8 pi, and of sum_j (n_j . u(x_j) - g_j)^2 / lambda_j.
    """

    def __init__(self, x, n, g, softness):
        kernel = -cdist(x, x) * (n @ n.T) + np.diag(softness)
        affine = (np.c_[np.ones(len(x)), x / 100][:, :, None] * n[:, None]).reshape(-1, 12)
        system = np.block([[kernel, affine], [affine.T, np.zeros((12, 12))]])
        solution = np.linalg.solve(system, np.r_[g, np.zeros(12)])
        self.x, self.force = x, n * solution[: len(x), None]
        self.affine = solution[len(x) :].reshape(4, 3)

    def __call__(self, x):
        return np.c_[np.ones(len(x)), x / 100] @ self.affine - cdist(x, self.x) @ self.force


def moved_normals(gradient, normals):
    """Unit normals F^-T n of a moved surface, F = I + gradient."""
    turned = np.linalg.solve((np.eye(3) + gradient).transpose(0, 2, 1), normals[..., None])[..., 0]
    return turned / np.linalg.norm(turned, axis=1)[:, None]


def point_spline(case, settings):
    """Spline through the known landmarks: constraints (x, n, g, softness) and the field."""
    k = case.known
    rows = (
        np.repeat(case.a[k], 3, 0),
        np.tile(np.eye(3), (len(k), 1)),
        (case.b - case.a)[k].ravel(),
        np.full(3 * len(k), settings.point_softness_mm),
    )
    return rows, Spline(*rows)


def sliding_spline(case, settings):
    """Spline through the known landmarks whose surfaces slide on the target's."""
    rows, field = point_spline(case, settings)
    for round_index, softness in enumerate(settings.slide_softness_mm):
        parts = [rows]
        for lung in case.lungs:
            normals = lung.n
            if round_index:
                steps = 3.0 * np.eye(3)
                gradient = [(field(lung.x + e) - field(lung.x - e)) / 6.0 for e in steps]
                normals = moved_normals(np.stack(gradient, 2), lung.n)
            index, n, gap = lung.match(lung.x + field(lung.x), normals, settings)
            parts.append((lung.x[index], n, gap, np.full(len(gap), softness)))
        field = Spline(*(np.concatenate(part) for part in zip(*parts, strict=True)))
    return field


def cubic(t):
    """Values, first and second derivatives of the four cubic B-splines of a cell at t in [0, 1]."""
    t = t[:, None]
    return (
        np.hstack([(1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, 3 * (t + t**2 - t**3) + 1, t**3]) / 6,
        np.hstack([-((1 - t) ** 2), 3 * t**2 - 4 * t, -3 * t**2 + 2 * t + 1, t**2]) / 2,
        np.hstack([1 - t, 3 * t - 2, 1 - 3 * t, t]),
    )


FIRST = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
SECOND = ((2, 0, 0), (0, 2, 0), (0, 0, 2), (1, 1, 0), (1, 0, 1), (0, 1, 1))


class ElasticLung:
    """Elastic energy of one lung over coefficients of cubic B-splines, components in blocks.

    W is the mean over the lung of 2 |dev(e - r)|^2 + kappa tr(e - r)^2 and
    beta |grad grad (u - a)|^2, plus the mean over the constraints of w (n . u - g)^2, in units of
    the shear modulus. e is the strain of u, a the affine map to the rest shape, and r the strain of
    a plus the eigenstrain.
    """

    def __init__(self, lung, settings):
        self.lung, self.settings = lung, settings
        low, high = lung.voxels_from.min(0) - 6, lung.voxels_from.max(0) + 6
        self.h, self.low = settings.control_mm, low
        self.count = np.ceil((high - low) / self.h).astype(int) + 3
        self.size = n = int(np.prod(self.count))
        index = np.stack(np.meshgrid(*map(np.arange, self.count), indexing="ij"), -1)
        self.control = (index.reshape(-1, 3) - 1) * self.h + low
        random = np.random.default_rng(0)
        self.quadrature = lung.voxels_from[random.choice(len(lung.voxels_from), 1500)]
        self.slopes = [self.basis(self.quadrature, d) for d in FIRST]
        self.surface = self.basis(lung.x)
        self.surface_slopes = [self.basis(lung.x, d) for d in FIRST]

        self.kappa = 2 * (1 + settings.poisson) / (3 * (1 - 2 * settings.poisson))
        self.divergence = np.concatenate(self.slopes, 1)
        pairs = [[p.T @ q for q in self.slopes] for p in self.slopes]
        bend = sum(
            (2 if max(d) == 1 else 1) * (b.T @ b)
            for d, b in ((d, self.basis(self.quadrature, d)) for d in SECOND)
        )
        trace = pairs[0][0] + pairs[1][1] + pairs[2][2] + settings.bending_mm2 * bend
        stiffness = (self.kappa - 2 / 3) * (self.divergence.T @ self.divergence)
        for i in range(3):
            for j in range(3):
                block = pairs[j][i] + (trace if i == j else 0)
                stiffness[i * n : i * n + n, j * n : j * n + n] += block
        self.stiffness = stiffness / len(self.quadrature) + 1e-9 * np.eye(3 * n)

    def basis(self, x, order=(0, 0, 0)):
        """Rows of the basis functions' derivatives at x."""
        f = (x - self.low) / self.h
        cell = np.clip(np.floor(f).astype(int), 0, self.count - 4)
        w = [cubic((f - cell)[:, d])[order[d]] for d in range(3)]
        w = w[0][:, :, None, None] * w[1][:, None, :, None] * w[2][:, None, None, :]
        i, j, k = ((cell[:, d, None] + np.arange(4)) for d in range(3))
        i, j, k = i[:, :, None, None], j[:, None, :, None], k[:, None, None, :]
        at = (i * self.count[1] + j) * self.count[2] + k
        rows = np.zeros((len(x), self.size))
        np.put_along_axis(rows, at.reshape(len(x), -1), w.reshape(len(x), -1), 1)
        return rows / self.h ** sum(order)

    def solve(self):
        """Coefficients of the displacement [mm], one row per control point."""
        lung, settings = self.lung, self.settings
        centre, spread = lung.voxels_from.mean(0), lung.voxels_from.std(0)
        volume = (len(lung.voxels_to) / len(lung.voxels_from)) ** (1 / 3)
        scale = lung.voxels_to.std(0) / spread if settings.box_rest else np.full(3, volume)
        u = (self.control - centre) * scale + lung.voxels_to.mean(0) - self.control
        where = (self.quadrature - centre) / spread
        excess = (volume - 1) * (settings.gravity * where[:, 1] - settings.base * where[:, 2])
        load = self.stiffness @ u.T.ravel()
        load += 3 * self.kappa * (self.divergence.T @ excess) / len(excess)
        shear = np.zeros((3, self.size))
        shear[1], shear[2] = self.slopes[2].mean(0), self.slopes[1].mean(0)
        load += 2 * settings.pitch * (volume - 1) * shear.ravel()
        normals = lung.n
        for weight in settings.slide_weight:
            index, n, gap = lung.match(lung.x + self.surface @ u, normals, settings)
            rows = np.concatenate([n[:, d, None] * self.surface[index] for d in range(3)], 1)
            weight /= len(gap)
            factor = cho_factor(self.stiffness + weight * (rows.T @ rows), overwrite_a=True)
            u = cho_solve(factor, load + weight * (rows.T @ gap)).reshape(3, -1).T
            gradient = np.stack([slope @ u for slope in self.surface_slopes], 2)
            normals = moved_normals(gradient, lung.n)
        return u

    def least_determinant(self, u):
        """Smallest det(I + grad u) over the lung."""
        return np.linalg.det(np.eye(3) + np.stack([s @ u for s in self.slopes], 2)).min()


def least_determinant(field, lungs):
    """Smallest det(I + grad u) over the lungs' voxels, one in 50."""
    x = np.concatenate([lung.voxels_from[::50] for lung in lungs])
    gradient = [(field(x + e) - field(x - e)) / 6.0 for e in 3.0 * np.eye(3)]
    return np.linalg.det(np.eye(3) + np.stack(gradient, 2)).min()


def nothing(case, _):
    return np.zeros_like(case.a), np.nan


def points(case, settings):
    field = point_spline(case, replace(settings, point_softness_mm=1e-3))[1]
    return field(case.a), least_determinant(field, case.lungs) if hasattr(case, "lungs") else np.nan


def points_masks(case, settings):
    field = sliding_spline(case, settings)
    return field(case.a), least_determinant(field, case.lungs)


def elastic_points_masks(case, settings):
    """The elastic lung, softly in contact, and a sliding spline of the residual displacements."""
    soft = replace(settings, slide_weight=settings.slide_weight[:2])
    trend = np.zeros_like(case.a)
    shifts = []
    for label, lung in enumerate(case.lungs):
        body = ElasticLung(lung, soft)
        coefficients = body.solve()
        here = case.side == label + 1
        trend[here] = body.basis(case.a[here]) @ coefficients
        shifts.append(body.surface @ coefficients)
    k = case.known
    rows = (
        np.repeat(case.a[k], 3, 0),
        np.tile(np.eye(3), (len(k), 1)),
        (case.b - case.a - trend)[k].ravel(),
        np.full(3 * len(k), settings.point_softness_mm),
    )
    field = Spline(*rows)
    for softness in settings.slide_softness_mm:
        parts = [rows]
        for lung, shift in zip(case.lungs, shifts, strict=True):
            index, n, gap = lung.match(lung.x + shift + field(lung.x), lung.n, settings)
            gap -= (n * shift[index]).sum(1)
            parts.append((lung.x[index], n, gap, np.full(len(gap), softness)))
        field = Spline(*(np.concatenate(part) for part in zip(*parts, strict=True)))
    return trend + field(case.a), np.nan


def masks(case, settings):
    u = np.zeros_like(case.a)
    least = []
    for label, lung in enumerate(case.lungs):
        body = ElasticLung(lung, settings)
        coefficients = body.solve()
        here = case.side == label + 1
        u[here] = body.basis(case.a[here]) @ coefficients
        least.append(body.least_determinant(coefficients))
    return u, min(least)


def report(name, method, cases, settings):
    """Prints the error of each case and their mean [mm], time, and the least determinant."""
    start = time.process_time()
    results = [method(case, settings) for case in cases]
    seconds = (time.process_time() - start) / len(cases)
    errors = [case.error(u) for case, (u, _) in zip(cases, results, strict=True)]
    least = min(det for _, det in results)
    cells = " ".join(f"{e:6.2f}" for e in [*errors, np.mean(errors)])
    print(f"{name:34s} {cells}   {seconds:5.2f} s   det >= {least:.2f}", flush=True)


def changed(value, factor):
    """A number times the factor, or all numbers of a tuple."""
    return tuple(v * factor for v in value) if isinstance(value, tuple) else value * factor


def main():
    """Prints a line for each method: cases 1 to 5, mean, processor time, least determinant."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--sweep", action="store_true")
    options = parser.parse_args()
    settings = Settings()
    four = [Case(options.data, "4dct", number, settings) for number in CASES]
    report("4DCT, nothing moves", nothing, four, settings)
    report("4DCT, points", points, four, settings)
    copd = [Case(options.data, "copd", number, settings) for number in CASES]
    report("COPD, nothing moves", nothing, copd, settings)
    report("COPD, points", points, copd, settings)
    report("COPD, points and masks", points_masks, copd, settings)
    report("COPD, elastic, points and masks", elastic_points_masks, copd, settings)
    report("COPD, masks", masks, copd, settings)
    plain = replace(settings, gravity=0.0, base=0.0, pitch=0.0)
    report("COPD, masks, no eigenstrain", masks, copd, plain)
    report("COPD, masks, uniform rest", masks, copd, replace(settings, box_rest=False))
    if not options.sweep:
        return
    for method, names in (
        (points_masks, ("point_softness_mm", "slide_softness_mm")),
        (masks, ("bending_mm2", "slide_weight", "gravity", "base", "pitch")),
    ):
        for name in names:
            for factor in (0.5, 1.5):
                other = replace(settings, **{name: changed(getattr(settings, name), factor)})
                report(f"{method.__name__}, {name} x {factor}", method, copd, other)
    for weights in ((0.003,), (0.003, 0.01), (0.003, 0.01, 0.03, 0.1)):
        other = replace(settings, slide_weight=weights)
        report(f"masks, weights to {weights[-1]}", masks, copd, other)
    for factor in (0.5, 1.5):
        other = [
            Case(options.data, "copd", number, replace(settings, normal_mm=20 * factor))
            for number in CASES
        ]
        near = replace(settings, normal_mm=20 * factor)
        report(f"points_masks, normal_mm x {factor}", points_masks, other, near)
        report(f"masks, normal_mm x {factor}", masks, other, near)
    report("masks, poisson 0.3", masks, copd, replace(settings, poisson=0.3))
    report("masks, poisson -0.5", masks, copd, replace(settings, poisson=-0.5))


if __name__ == "__main__":
    main()
