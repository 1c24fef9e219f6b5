// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The volumes of a series. Slices of different shapes are in different volumes. Slices of one shape
// may be a series of volumes, such as points in time; they then have numbers: the Temporal Position
// Index and the Dimension Index Values of frames, the Temporal Position Identifier of files.
// Numbers that are equal for all slices at the same position count positions or stacks; the others
// count volumes:
//
//     position    0 mm     2 mm     4 mm
//     numbers     1 1 1    1 2 1    1 3 1      the second number counts positions,
//                 2 1 1    2 2 1    2 3 1      the first one volumes

#include "formats/dicom_series.h"

#include "base/errors.h"
#include "formats/dicom_folder.h"
#include "formats/dicom_input.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <numeric>
#include <utility>

namespace pliant {
namespace {

/// Numbers of the slices of each volume.
using Volumes = std::vector<std::vector<std::size_t>>;

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

/// Volumes of slices of one shape, by their numbers.
/// @returns empty if two slices at the same position have the same numbers, or there are none
Volumes volumes_by_number(const std::vector<DicomSlice>& slices,
                          const std::vector<std::size_t>& positions) {
    const std::size_t count = slices.front().numbers.size();
    for (const DicomSlice& slice : slices)
        if (slice.numbers.size() != count) return {};
    std::vector<std::size_t> kept;
    for (std::size_t number = 0; number < count; ++number)
        if (counts_volumes(number, slices, positions)) kept.push_back(number);
    // Signed: on big-endian machines GCC 12 compares only the first bytes of unsigned numbers.
    std::map<std::vector<std::int64_t>, std::vector<std::size_t>> volumes;
    for (std::size_t n = 0; n < slices.size(); ++n) {
        std::vector<std::int64_t> key;
        for (const std::size_t number : kept) key.push_back(slices[n].numbers[number]);
        volumes[key].push_back(n);
    }
    Volumes split;
    for (auto& [key, members] : volumes) {
        std::vector<std::size_t> own;
        for (const std::size_t n : members) own.push_back(positions[n]);
        std::sort(own.begin(), own.end());
        if (std::adjacent_find(own.begin(), own.end()) != own.end()) return {};
        split.push_back(std::move(members));
    }
    return split;
}

/// Volumes of files with one slice each: the n-th has the n-th Instance Number at each position.
/// @returns empty if positions have different numbers of slices, or slices no or equal numbers
Volumes volumes_by_instance(const std::vector<DicomSlice>& slices,
                            const std::vector<std::size_t>& positions) {
    std::map<std::size_t, std::map<std::int64_t, std::size_t>> stacks;
    for (std::size_t n = 0; n < slices.size(); ++n) {
        if (slices[n].frame || !slices[n].instance_number) return {};
        if (!stacks[positions[n]].emplace(*slices[n].instance_number, n).second) return {};
    }
    Volumes split(stacks.begin()->second.size());
    for (const auto& [position, stack] : stacks) {
        if (stack.size() != split.size()) return {};
        auto volume = split.begin();
        for (const auto& [number, n] : stack) (volume++)->push_back(n);
    }
    return split;
}

/// Volumes of slices of one shape; one if they can't be told apart.
Volumes volumes_of(const std::vector<DicomSlice>& slices) {
    const std::vector<std::size_t> positions = positions_of(slices);
    Volumes split = volumes_by_number(slices, positions);
    if (split.empty()) split = volumes_by_instance(slices, positions);
    if (!split.empty()) return split;
    split.resize(1);
    for (std::size_t n = 0; n < slices.size(); ++n) split.front().push_back(n);
    return split;
}

bool have_same_pixels(const DicomSlice& a, const DicomSlice& b) {
    const DicomPixels &p = a.pixels, &q = b.pixels;
    if (p.syntax.uid != q.syntax.uid || p.parts.size() != q.parts.size()) return false;
    DicomInput first(a.path), second(b.path);
    if (p.deflated_from && !first.inflate_from(p.deflated_from)) return false;
    if (q.deflated_from && !second.inflate_from(q.deflated_from)) return false;
    std::array<char, 1 << 14> one{}, other{};
    for (std::size_t n = 0; n < p.parts.size(); ++n) {
        if (p.parts[n].bytes != q.parts[n].bytes) return false;
        first.seek(p.parts[n].start);
        second.seek(q.parts[n].start);
        for (std::uint64_t left = p.parts[n].bytes; left > 0;) {
            const auto count = std::size_t(std::min<std::uint64_t>(left, one.size()));
            if (first.read(one.data(), count) != count) return false;
            if (second.read(other.data(), count) != count) return false;
            if (std::memcmp(one.data(), other.data(), count) != 0) return false;
            left -= count;
        }
    }
    return true;
}

/// Leaves out copies of slices, which have the same SOP Instance UID, position and pixels.
void drop_copies(std::vector<DicomSlice>& slices, std::vector<std::string>& notes) {
    std::map<std::pair<std::string, int>, std::vector<const DicomSlice*>> known;
    std::vector<DicomSlice> kept;
    kept.reserve(slices.size());
    std::size_t copies = 0;
    std::string example;
    for (DicomSlice& slice : slices) {
        if (slice.instance_uid.empty()) {
            kept.push_back(std::move(slice));
            continue;
        }
        auto& others = known[{slice.instance_uid, slice.frame}];
        const auto is_copy = [&](const DicomSlice* other) {
            return other->position == slice.position && other->numbers == slice.numbers &&
                   !difference_of(*other, slice) && have_same_pixels(*other, slice);
        };
        const auto original = std::find_if(others.begin(), others.end(), is_copy);
        if (original != others.end()) {
            if (copies++ == 0) example = slice.name() + " of " + (*original)->name();
            continue;
        }
        others.push_back(&kept.emplace_back(std::move(slice)));
    }
    slices = std::move(kept);
    if (copies)
        notes.push_back(counted(copies, "copy", "copies") + " of slices left out: " + example);
}

/// Slices by their shape, the largest group first. Beyond a number of shapes only the last one is
/// compared.
std::vector<std::vector<DicomSlice>> shapes_of(std::vector<DicomSlice> slices) {
    constexpr std::size_t kMaxCompared = 256;
    std::vector<std::vector<DicomSlice>> groups;
    for (DicomSlice& slice : slices) {
        const auto from = groups.size() > kMaxCompared ? groups.end() - 1 : groups.begin();
        const auto own = std::find_if(from, groups.end(), [&](const auto& group) {
            return !difference_of(group.front(), slice);
        });
        (own == groups.end() ? groups.emplace_back() : *own).push_back(std::move(slice));
    }
    std::stable_sort(groups.begin(), groups.end(),
                     [](const auto& a, const auto& b) { return a.size() > b.size(); });
    return groups;
}

/// Leaves out localizers beside a volume: groups of that Image Type, and of at most two slices
/// beside many.
void drop_localizers(std::vector<std::vector<DicomSlice>>& groups,
                     std::vector<std::string>& notes) {
    constexpr std::size_t kMaxFew = 2, kMinMany = 8;
    const auto are_localizers = [](const std::vector<DicomSlice>& group) {
        return std::all_of(group.begin(), group.end(), [](auto& s) { return s.is_localizer; });
    };
    const auto volume = std::find_if_not(groups.begin(), groups.end(), are_localizers);
    if (volume == groups.end()) return;  // a series of localizers
    const bool is_large = volume->size() >= kMinMany;
    const DicomSlice first = volume->front();
    std::erase_if(groups, [&](const std::vector<DicomSlice>& group) {
        const char* const difference = difference_of(first, group.front());
        if (!difference) return false;
        if (!are_localizers(group) && !(is_large && group.size() <= kMaxFew)) return false;
        notes.push_back(counted(group.size(), "slice", "slices") + " of another " + difference +
                        " left out, such as a localizer: " + group.front().name());
        return true;
    });
}

}  // namespace

Status place_in_order(const std::filesystem::path& path, std::vector<DicomSlice>& slices,
                      Vec3d spacing_mm, std::vector<std::string>& notes) {
    for (DicomSlice& slice : slices) {
        slice.position = {};
        slice.numbers.clear();
        slice.row = {1, 0, 0};
        slice.column = {0, 1, 0};
        slice.spacing_mm = {spacing_mm.x, spacing_mm.y, 0};
        slice.thickness_mm = spacing_mm.z;
    }
    drop_copies(slices, notes);
    const auto rank = [](const DicomSlice& s) {
        return std::pair(s.instance_number.value_or(0), s.frame);
    };
    std::stable_sort(slices.begin(), slices.end(),
                     [&](const DicomSlice& a, const DicomSlice& b) { return rank(a) < rank(b); });
    for (std::size_t n = 0; n < slices.size(); ++n) {
        if (n > 0 && rank(slices[n]) == rank(slices[n - 1]))
            return unsupported(path, slices[n - 1].name() + " and " + slices[n].name() +
                                         " have no positions and no different Instance Numbers, "
                                         "expected one of them");
        slices[n].position.z = double(n) * spacing_mm.z;
        slices[n].lacks_geometry = false;
    }
    notes.push_back("no positions: " + counted(slices.size(), "slice is", "slices are") +
                    " stacked in the order of their numbers, by the given spacing; left, front and "
                    "head are unknown");
    return Ok{};
}

std::vector<std::vector<DicomSlice>> split_volumes(std::vector<DicomSlice> slices,
                                                   std::vector<std::string>& notes) {
    drop_copies(slices, notes);
    auto groups = shapes_of(std::move(slices));
    drop_localizers(groups, notes);
    std::vector<std::vector<DicomSlice>> split;
    for (std::vector<DicomSlice>& group : groups)
        for (const std::vector<std::size_t>& members : volumes_of(group))
            for (auto& volume = split.emplace_back(); const std::size_t n : members)
                volume.push_back(std::move(group[n]));
    return split;
}

}  // namespace pliant
