# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Hyperelastic laws for felupe, and meshes of quadratic cells between given lines."""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import felupe as fem
import numpy as np


class Law(fem.Material):
    """W = mu/2 (tr C - 3) + g(J), or with the isochoric invariant: mu/2 (J^(-2/3) tr C - 3) + g(J).

    first and second are the derivatives of g.
    """

    def __init__(self, mu, first, second, isochoric):
        super().__init__(self._stress, self._elasticity)
        self.part = fem.NeoHooke(mu=mu, bulk=0.0) if isochoric else None
        self.mu, self.first, self.second = mu, first, second

    def _stress(self, x, **kwargs):
        f = x[0]
        j = np.linalg.det(f.T).T
        inverse = fem.math.transpose(fem.math.inv(f))
        p = self.first(j) * j * inverse
        p = p + (self.part.gradient([f, None])[0] if self.part else self.mu * f)
        return [p, x[-1]]

    def _elasticity(self, x, **kwargs):
        f = x[0]
        j = np.linalg.det(f.T).T
        inverse = fem.math.transpose(fem.math.inv(f))
        a = (self.second(j) * j + self.first(j)) * j * np.einsum(
            "iJ...,kL...->iJkL...", inverse, inverse
        ) - self.first(j) * j * np.einsum("iL...,kJ...->iJkL...", inverse, inverse)
        if self.part:
            return [a + self.part.hessian([f, None])[0]]
        unit = np.einsum("ik,JL->iJkL", np.eye(3), np.eye(3))
        return [a + self.mu * unit[..., None, None]]


def body_law(young, nu):
    """Neo-Hookean law of Pliant's bodies: g = -mu (J - 1) + (lambda + mu)/2 (J - 1)^2."""
    mu = young / (2 * (1 + nu))
    lam = 2 * mu * nu / (1 - 2 * nu)
    return Law(mu, lambda j: -mu + (lam + mu) * (j - 1), lambda j: lam + mu + 0 * j, False)


def isochoric_law(young, nu):
    """Neo-Hookean law with an isochoric invariant: g = K/4 (J^2 - 1 - 2 ln J)."""
    mu, bulk = young / (2 * (1 + nu)), young / (3 * (1 - 2 * nu))
    return Law(mu, lambda j: bulk / 2 * (j - 1 / j), lambda j: bulk / 2 * (1 + 1 / j**2), True)


def lattice(*lines):
    """Quadratic quadrilaterals or hexahedra (27 nodes) with the given corner coordinates."""
    counts = [len(line) for line in lines]
    ends = tuple(n - 1 for n in counts)
    mesh = (fem.Rectangle if len(lines) == 2 else fem.Cube)(b=ends, n=tuple(counts))
    for axis, line in enumerate(lines):
        mesh.points[:, axis] = np.interp(mesh.points[:, axis], range(counts[axis]), line)
    mesh = fem.mesh.add_midpoints_edges(mesh)
    mesh = fem.mesh.add_midpoints_faces(mesh)
    return mesh if len(lines) == 2 else fem.mesh.add_midpoints_volumes(mesh)


def graded(count, power):
    """Lines from 0 to 1 that are denser at 0."""
    return np.linspace(0, 1, count + 1) ** power


def shares(coordinates):
    """Simpson's weights of sorted node coordinates, two for each cell and a last one."""
    weights = np.zeros(len(coordinates))
    for n in range(0, len(coordinates) - 1, 2):
        weights[n : n + 3] += (coordinates[n + 2] - coordinates[n]) / 6 * np.array([1, 4, 1])
    return weights
