# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Beads of a gel before and after an indentation, and links between them.

Near the glass the gel hardly moves, so beads are linked with their nearest neighbour. Links then
spread upwards: around a bead without a link, an affine map is fitted to the displacements of the 20
nearest linked beads, and the bead is linked with the bead that lies where the map predicts it.
No mechanical model takes part.
"""

import numpy as np
from scipy.spatial import cKDTree

NEIGHBOURS = 20
START_UM = 20.0  # depth of the beads that are linked with their nearest neighbour
REACH_UM = (15.0, 15.0, 21.0)  # mean distance of the neighbours, by round modulo 3
GATE_UM = (0.7, 1.4)  # smallest and largest distance of a link from its prediction
ROUGH_UM = 0.7  # neighbours whose median deviation from the map is larger predict nothing


def read_beads(folder):
    """Reads the bead centres before and after [um], z upwards from the glass."""
    return [
        np.loadtxt(folder / f"beads_{when}.csv.gz", delimiter=",", skiprows=1)
        for when in ("before", "after")
    ]


def stage_drift(before, after):
    """Rigid shift of the lowest beads [um], which the gel's deformation doesn't reach."""
    low = before[before[:, 2] < START_UM]
    tree = cKDTree(after)
    shift = np.zeros(3)
    for _ in range(8):
        distance, near = tree.query(low + shift)
        close = distance < 1.5
        shift = np.median((after[near] - low)[close], axis=0)
    return shift


def predict(points, known, displacement, skip_self=False):
    """Displacement at points by robust local affine maps.

    Returns the displacements, the median deviations of the neighbours, and their mean distances.
    """
    first = int(skip_self)
    distance, near = cKDTree(known).query(points, k=NEIGHBOURS + first)
    distance, near = distance[:, first:], near[:, first:]
    basis = np.concatenate([np.ones(near.shape + (1,)), known[near] - points[:, None]], axis=2)
    values = displacement[near]
    weight = close = np.exp(-((1.2 * distance / distance[:, -1:]) ** 2))
    ridge = np.diag([0.0, 1.0, 1.0, 1.0])  # [um^2]
    for _ in range(3):
        weighted = np.swapaxes(basis * weight[..., None], 1, 2)
        matrix = weighted @ basis + ridge * weight.sum(axis=1)[:, None, None]
        maps = np.linalg.solve(matrix, weighted @ values)
        off = np.linalg.norm(values - basis @ maps, axis=2)
        spread = np.maximum(np.median(off, axis=1), 0.1)
        weight = close / (1 + (off / (2 * spread[:, None])) ** 2)
    return maps[:, 0], spread, distance.mean(axis=1)


def near_to(points, others, reach):
    """Whether each point has one of the others within reach."""
    return cKDTree(others).query(points, distance_upper_bound=reach)[0] < reach


def link_beads(before, after, drift, rounds=60):
    """Links beads; returns the index after, or -1, of each bead before."""
    tree = cKDTree(after)
    link = np.full(len(before), -1)
    low = np.flatnonzero(before[:, 2] < START_UM)
    distance, near = tree.query(before[low] + drift)
    close = distance < 1.0
    link[low[close]] = near[close]
    fresh = np.flatnonzero(link >= 0)
    for turn in range(rounds):
        reach = REACH_UM[turn % len(REACH_UM)]
        # Links that contradict their neighbours are removed.
        linked = np.flatnonzero(link >= 0)
        moved = after[link[linked]] - before[linked]
        suspect = near_to(before[linked], before[fresh], REACH_UM[0])
        where, spread, _ = predict(before[linked[suspect]], before[linked], moved, skip_self=True)
        off = np.linalg.norm(moved[suspect] - where, axis=1)
        link[linked[suspect][off > np.clip(4 * spread, 0.8, 1.6)]] = -1
        # New ones, each bead after at most once.
        linked = np.flatnonzero(link >= 0)
        free = np.flatnonzero(link < 0)
        if turn % 3 != 2:
            free = free[near_to(before[free], before[fresh], 25.0)]
        moved = after[link[linked]] - before[linked]
        where, spread, far = predict(before[free], before[linked], moved)
        distance, near = tree.query(before[free] + where)
        good = (far < reach) & (spread < ROUGH_UM) & (distance < np.clip(4 * spread, *GATE_UM))
        good &= ~np.isin(near, link[linked])
        order = np.flatnonzero(good)[np.argsort(distance[good], kind="stable")]
        order = order[np.unique(near[order], return_index=True)[1]]
        link[free[order]] = near[order]
        fresh = free[order]
        if turn > 12 and len(fresh) < 10:
            break
    return link
