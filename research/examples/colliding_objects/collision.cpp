// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "collision.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <span>
#include <utility>

namespace collision {
namespace {

using namespace pliant;

constexpr std::int16_t kVoid = -1000, kSoft = 40, kFixed = 1000;  // values of elements
constexpr double kTouch_mm = 1e-5;  // boxes that are closer than this touch

/// One layer of elements, 1 mm apart, with its first element at a given position.
Volume layer(Vec3i size, Vec3d origin_mm, const std::function<std::int16_t(int, int)>& value) {
    Volume volume;
    volume.grid.size = size;
    volume.grid.origin_mm = origin_mm;
    std::vector<std::int16_t> voxels;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) voxels.push_back(value(x, y));
    volume.voxels = std::move(voxels);
    return volume;
}

Volume ring() {
    return layer({19, 19, 1}, {4, 14, 0}, [](int x, int y) {
        const double r = std::hypot(x - 9, y - 9);
        return r < 9.3 && r > 3.5 ? kSoft : kVoid;
    });
}

Volume tissue_with_bay() {
    return layer({30, 46, 1}, {34, 0, 0}, [](int x, int y) {
        if (x >= 28) return kFixed;
        return std::hypot(x, y - 23) < 13 ? kVoid : kSoft;
    });
}

/// Links of soft material may be compressed, stretched and sheared by a fraction of their length.
ChainMailSettings material(double fraction) {
    ChainMailSettings settings;
    settings.custom_law = [=](int value) {
        return ElementLimits{.compress = {fraction, fraction, fraction},
                             .stretch = {fraction, fraction, fraction},
                             .shear = {fraction, fraction, fraction},
                             .max_movement_mm = 500,
                             .fixed = value == kFixed};
    };
    return settings;
}

std::vector<Vec3i> patch(Vec3i low, Vec3i high) {
    std::vector<Vec3i> elements;
    for (int y = low.y; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x) elements.push_back({x, y, 0});
    return elements;
}

void see(const ObjectSpace& space, Frame& frame) {
    for (int object = 0; object < space.object_count(); ++object) {
        const Volume& volume = space.object(object).volume();
        std::vector<Element>& elements = frame.objects.emplace_back();
        for (const Vec3i& e : patch({0, 0, 0}, volume.grid.size - Vec3i{1, 1, 1})) {
            if (!space.is_solid(object, e)) continue;
            const Vec3d place = space.position_mm(object, e);
            elements.push_back({e, place.x, place.y, volume.at(e) == kFixed});
        }
    }
}

struct Step {
    const char* title;
    int object;
    std::vector<Vec3i> grabbed;
    Vec3d push_mm;
};

std::vector<Step> steps() {
    return {{"2: ring pulled by its front", kRing, patch({15, 7, 0}, {17, 11, 0}), {34, 4, 0}},
            {"3: ring pushed from behind", kRing, patch({1, 7, 0}, {3, 11, 0}), {14, 3, 0}},
            {"4: lip of the tissue pulled down", kTissue, patch({0, 5, 0}, {6, 8, 0}), {-3, 14, 0}},
            {"5: ring pulled back", kRing, patch({1, 7, 0}, {3, 11, 0}), {-36, 3.5, 0}}};
}

Result<Frame> push(ObjectSpace& space, const Step& step) {
    Frame frame;
    frame.title = step.title;
    frame.pushed = step.object;
    frame.grabbed = step.grabbed;
    frame.push_mm = step.push_mm;
    for (const Vec3i& e : step.grabbed)
        frame.start_mm =
            frame.start_mm + 1.0 / double(step.grabbed.size()) * space.position_mm(step.object, e);
    auto report = space.push_elements(step.object, step.grabbed, step.push_mm);
    if (!report) return report.error();
    frame.report = *report;
    see(space, frame);
    return frame;
}

/// By how much two boxes overlap on the axis where they do least [mm]; negative: the gap.
double overlap_mm(const Element& a, const Element& b) {
    return 1 - std::max(std::abs(a.x_mm - b.x_mm), std::abs(a.y_mm - b.y_mm));
}

double deepest_overlap_mm(const std::vector<Element>& a, const std::vector<Element>& b) {
    double deepest = -1e9;
    for (const Element& p : a)
        for (const Element& q : b) deepest = std::max(deepest, overlap_mm(p, q));
    return deepest;
}

const Element* find(const std::vector<Element>& elements, Vec3i ijk) {
    const auto found = std::find_if(elements.begin(), elements.end(),
                                    [&](const Element& e) { return e.ijk == ijk; });
    return found == elements.end() ? nullptr : &*found;
}

/// How far an object's elements moved between two frames, at most [mm].
double moved_mm(const std::vector<Element>& before, const std::vector<Element>& after) {
    double most = 0;
    for (std::size_t n = 0; n < before.size(); ++n)
        most = std::max(most,
                        std::hypot(after[n].x_mm - before[n].x_mm, after[n].y_mm - before[n].y_mm));
    return most;
}

std::string fault_of_stop(const Frame& frame) {
    const ObjectPushReport& report = frame.report;
    const Element* met = find(frame.objects[std::size_t(frame.pushed)], report.element);
    if (!met) return "expected the report to name a solid element";
    if (report.wall >= 0)
        return std::abs(met->x_mm - 0.5 - kWall_mm) < kTouch_mm ? "" : "stopped beside the wall";
    if (report.object < 0) return "expected the push to meet something";
    const Element* other = find(frame.objects[std::size_t(report.object)], report.other_element);
    if (!other) return "expected the report to name a solid element of the other object";
    return overlap_mm(*met, *other) > -kTouch_mm ? "" : "stopped before the boxes touched";
}

}  // namespace

Result<std::vector<Frame>> play(const TaskArena& arena) {
    ObjectSpace space(arena);
    if (const auto added = space.add_object(ring(), material(0.3), true); !added)
        return added.error();
    if (const auto added = space.add_object(tissue_with_bay(), material(0.3), false); !added)
        return added.error();
    if (const auto added = space.add_wall({.point_mm = {kWall_mm, 0, 0}, .axis = 0, .side = 1});
        !added)
        return added.error();
    std::vector<Frame> frames(1);
    frames.front().title = "1: at rest";
    see(space, frames.front());
    for (const Step& step : steps()) {
        auto frame = push(space, step);
        if (!frame) return frame.error();
        frames.push_back(std::move(*frame));
    }
    return frames;
}

std::string find_fault(const std::vector<Frame>& frames) {
    for (std::size_t n = 0; n < frames.size(); ++n) {
        const Frame& frame = frames[n];
        const std::string where = frame.title + ": ";
        if (deepest_overlap_mm(frame.objects[kRing], frame.objects[kTissue]) > kTouch_mm)
            return where + "boxes overlap";
        for (const Element& e : frame.objects[kRing])
            if (e.x_mm - 0.5 < kWall_mm - kTouch_mm) return where + "a box is in the wall";
        if (n == 0) continue;
        const int other = 1 - frame.pushed;
        if (moved_mm(frames[n - 1].objects[std::size_t(other)], frame.objects[std::size_t(other)]) >
            0)
            return where + "the other object moved";
        if (const std::string fault = fault_of_stop(frame); !fault.empty()) return where + fault;
    }
    const auto meets_object = [&](std::size_t n) { return frames[n].report.object >= 0; };
    if (!meets_object(1) || !meets_object(2) || !meets_object(3) || frames[4].report.wall < 0)
        return "expected three pushes to meet an object and the last one the wall";
    return "";
}

}  // namespace collision
