// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A file of several frames may hold a series of volumes, such as points in time. Its frames then
// have numbers, the Temporal Position Index and the Dimension Index Values. Numbers that are equal
// for all frames at the same position count positions or stacks; the others count volumes:
//
//     position    0 mm     2 mm     4 mm
//     numbers     1 1 1    1 2 1    1 3 1      the second number counts positions,
//                 2 1 1    2 2 1    2 3 1      the first one volumes

#include "formats/dicom_series.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace pliant {
namespace {

/// Numbers the different heights along the common normal. @returns one number for each slice
std::vector<std::size_t> positions_of(const std::vector<DicomSlice>& slices) {
    const Vec3d normal = cross(slices.front().row, slices.front().column);
    std::vector<double> heights;
    for (const DicomSlice& slice : slices) heights.push_back(dot(slice.position, normal));
    std::vector<std::size_t> order(slices.size()), positions(slices.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return heights[a] < heights[b]; });
    for (std::size_t n = 1; n < order.size(); ++n)
        positions[order[n]] = positions[order[n - 1]] +
                              (heights[order[n]] - heights[order[n - 1]] >= kSameSliceMm ? 1 : 0);
    return positions;
}

bool have_same_axes(const std::vector<DicomSlice>& slices) {
    const DicomSlice& first = slices.front();
    return std::all_of(slices.begin(), slices.end(), [&](const DicomSlice& s) {
        return norm(s.row - first.row) <= kSameSliceAxes &&
               norm(s.column - first.column) <= kSameSliceAxes;
    });
}

/// Whether a number differs between slices at the same position.
bool counts_volumes(std::size_t number, const std::vector<DicomSlice>& slices,
                    const std::vector<std::size_t>& positions) {
    std::map<std::size_t, std::uint32_t> first;
    for (std::size_t n = 0; n < slices.size(); ++n) {
        const std::uint32_t own = slices[n].numbers[number];
        if (first.emplace(positions[n], own).first->second != own) return true;
    }
    return false;
}

}  // namespace

std::vector<std::vector<DicomSlice>> split_volumes(std::vector<DicomSlice> slices) {
    const auto whole = [&] {
        std::vector<std::vector<DicomSlice>> one;
        one.push_back(std::move(slices));
        return one;
    };
    if (slices.size() < 2) return whole();
    const std::size_t count = slices.front().numbers.size();
    for (const DicomSlice& slice : slices)
        if (slice.numbers.size() != count) return whole();
    if (count == 0 || !have_same_axes(slices)) return whole();
    const std::vector<std::size_t> positions = positions_of(slices);
    std::vector<std::size_t> kept;
    for (std::size_t number = 0; number < count; ++number)
        if (counts_volumes(number, slices, positions)) kept.push_back(number);
    std::map<std::vector<std::uint32_t>, std::vector<std::size_t>> volumes;
    for (std::size_t n = 0; n < slices.size(); ++n) {
        std::vector<std::uint32_t> key;
        for (const std::size_t number : kept) key.push_back(slices[n].numbers[number]);
        volumes[key].push_back(n);
    }
    for (const auto& [key, members] : volumes) {
        std::vector<std::size_t> own;
        for (const std::size_t n : members) own.push_back(positions[n]);
        std::sort(own.begin(), own.end());
        if (std::adjacent_find(own.begin(), own.end()) != own.end()) return whole();
    }
    std::vector<std::vector<DicomSlice>> split;
    for (const auto& [key, members] : volumes)
        for (auto& volume = split.emplace_back(); const std::size_t n : members)
            volume.push_back(std::move(slices[n]));
    return split;
}

}  // namespace pliant
