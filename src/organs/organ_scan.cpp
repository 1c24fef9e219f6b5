// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "organs/organ_scan.h"

#include <pliant/files.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/errors.h"
#include "resample/filled_scan.h"

namespace pliant {
namespace {

constexpr double kTissueHu = 60, kPatternHu = 25;
constexpr double kNextHu = -20;  ///< from one organ to the next, so that sections tell them apart
constexpr double kMarginShare = 0.15;   ///< of the longest side
constexpr double kVoxelShare = 0.0128;  ///< likewise: some 100 voxels with the margins
constexpr double kPatternShare = 0.06;
constexpr int kMaxVoxels = 256;

/// The largest of 1, 2 and 5 times a power of ten up to a length.
double round_down(double mm) {
    const double power = std::pow(10, std::floor(std::log10(mm)));
    return (mm >= 5 * power ? 5 : mm >= 2 * power ? 2 : 1) * power;
}

/// Triangle wave in −1…1; bit-identical on every machine, unlike a cosine.
double wave(double x) {
    return 4 * std::abs(x - std::floor(x) - 0.5) - 1;
}

struct Content {
    SurfaceDistance surface;
    double value_hu;
};

struct Place {
    double distance_mm = std::numeric_limits<double>::infinity();  ///< negative inside
    std::size_t organ = 0;                                         ///< the nearest one
    double next_mm = std::numeric_limits<double>::infinity();      ///< to any other surface
    double content_hu = 0;
    double content_mm = std::numeric_limits<double>::infinity();
    bool is_far(double reach_mm) const {
        return std::abs(distance_mm) > reach_mm && std::abs(next_mm) > reach_mm;
    }
};

Place place_of(Vec3d p, std::span<const SurfaceDistance> organs,
               std::span<const Content> contents) {
    Place place;
    const auto meet = [&](double distance) {
        place.next_mm = std::min(place.next_mm, std::abs(distance));
    };
    for (std::size_t n = 0; n < organs.size(); ++n) {
        const double distance = organs[n].signed_mm(p);
        if (n > 0) meet(distance);
        if (distance < place.distance_mm) {
            if (n > 0) meet(place.distance_mm);
            place.distance_mm = distance;
            place.organ = n;
        }
    }
    for (const Content& content : contents) {
        const double distance = content.surface.signed_mm(p);
        meet(distance);
        if (distance < place.content_mm) {
            place.content_mm = distance;
            place.content_hu = content.value_hu;
        }
    }
    return place;
}

Result<std::vector<Content>> read_contents(std::span<const OrganContents> contents) {
    std::vector<Content> read;
    for (const OrganContents& c : contents) {
        auto surface = read_surface(c.surface);
        if (!surface) return surface.error();
        auto distance = SurfaceDistance::create(joined(*surface));
        if (!distance) return within(c.surface, distance.error());
        read.push_back({std::move(*distance), c.value_hu});
    }
    return read;
}

}  // namespace

Result<Volume> scan_of_organs(std::span<const Organ> organs,
                              std::span<const OrganContents> contents, const TaskArena& arena) {
    std::vector<SurfaceDistance> surfaces;
    std::vector<Vec3d> nodes;
    for (const Organ& organ : organs) {
        auto surface = SurfaceDistance::create(boundary_triangles(organ.mesh));
        if (!surface) return within(organ.name, surface.error());
        surfaces.push_back(std::move(*surface));
        nodes.insert(nodes.end(), organ.mesh.nodes_mm.begin(), organ.mesh.nodes_mm.end());
    }
    const auto inner = read_contents(contents);
    if (!inner) return inner.error();
    Vec3d low = nodes.front(), high = low;
    for (const Vec3d& p : nodes)
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    const Vec3d span = high - low;
    const double longest = std::max({span.x, span.y, span.z});
    Volume volume;
    volume.grid =
        grid_around(nodes, kMarginShare * longest, round_down(kVoxelShare * longest), kMaxVoxels);
    const double voxel = volume.grid.spacing_mm.x, pattern = round_down(kPatternShare * longest);
    const auto share_of = [&](double distance) {
        return std::clamp(0.5 - distance / voxel, 0.0, 1.0);
    };
    volume.voxels = filled(
        volume.grid, arena, [&](Vec3d p) { return place_of(p, surfaces, *inner); },
        [&](Vec3d p, const Place& place) {
            const double own =
                kTissueHu + kNextHu * double(place.organ % 4) +
                kPatternHu * wave(p.x / pattern) * wave(p.y / pattern) * wave(p.z / pattern);
            const double part = share_of(place.content_mm);
            const double inside = part * place.content_hu + (1 - part) * own;
            const double share = share_of(place.distance_mm);
            return std::round(share * inside + (1 - share) * kAirHu);
        });
    return volume;
}

}  // namespace pliant
