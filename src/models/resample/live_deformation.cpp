// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <type_traits>
#include <utility>
#include <variant>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "resample/scatter.h"
#include "resample/source_jacobian.h"

namespace pliant {
namespace {

constexpr std::int64_t kLiveRowsPerTask = 64;

struct FreeMemory {
    void operator()(void* memory) const { std::free(memory); }
};

}  // namespace

struct LiveDeformation::Impl {
    Impl(const MovingScan& t, Volume deformed)
        : tissue(&t), volume(std::move(deformed)), scatter(t.volume(), t.arena()) {}

    LiveUpdate write() {
        if (is_behind) scatter.start_over(volume, inverse_mm.get());
        is_behind = true;
        const Field& field = tissue->deformation().field();
        const OpenVoxels open = scatter.look(field, Mapping::Cells, volume);
        if (inverse_mm) scatter.clear_inverse(field, inverse_mm.get());
        LiveUpdate update;
        update.gap_voxels =
            scatter.write(field, Mapping::Cells, volume, inverse_mm.get(), voxel_box(volume.grid));
        update.written_voxels = open.count;
        update.dirty_box = open.box;
        update.boxes = scatter.written_boxes();
        is_behind = false;
        return update;
    }

    /// @param place  writes the tissue's deformation, and returns whether it is the present one
    template <class Place>
    Result<LiveUpdate> update(const Place& place) noexcept {
        const Stopwatch watch;
        return attempt([&]() -> Result<LiveUpdate> {
            const Result<bool> placed = place();
            if (!placed.ok()) return placed.error();
            LiveUpdate update = write();
            update.is_complete = *placed;
            update.resample_ms = watch.ms();
            return update;
        });
    }

    /// Calls work(p, sources of the row, values of the row) for each row of a box.
    template <class Work>
    void for_rows(const Box3i& box, std::span<float> values, const Work& work) const {
        const Vec3i n = box.end - box.begin;
        const auto task = [&](std::int64_t begin, std::int64_t end) {
            work([&](auto&& one) {
                for (std::int64_t row = begin; row < end; ++row) {
                    const Vec3i p = box.begin + Vec3i{0, int(row % n.y), int(row / n.y)};
                    const Vec3f* back = inverse_mm.get() + voxel_index(volume.grid, p);
                    float* to = values.data() + row * n.x;
                    for (int x = 0; x < n.x; ++x) to[x] = one(p + Vec3i{x, 0, 0}, back[x]);
                }
            });
        };
        tissue->arena().for_each(std::int64_t(n.y) * n.z, kLiveRowsPerTask, std::ref(task));
    }

    const MovingScan* tissue;
    Volume volume;
    Scatter scatter;
    bool is_behind = false;  ///< the last update failed
    /// Untouched memory stays unused: only pages with deformed voxels become resident.
    std::unique_ptr<Vec3f[], FreeMemory> inverse_mm;
};

Result<LiveDeformation> LiveDeformation::create(const MovingScan& scan) noexcept {
    return attempt([&]() -> Result<LiveDeformation> {
        return LiveDeformation(std::make_unique<Impl>(scan, scan.volume()));
    });
}

Result<LiveDeformation> LiveDeformation::create(const MovingScan& scan, Volume target) noexcept {
    return attempt([&]() -> Result<LiveDeformation> {
        const Volume& rest = scan.volume();
        if (const Status s = check_volume(target, "target"); !s.ok()) return s.error();
        if (target.grid.size != rest.grid.size || target.is_16_bit() != rest.is_16_bit())
            return invalid("target: expected the scan's size and type of voxels");
        target.grid = rest.grid;
        target.background = rest.background;
        std::visit(
            [&](auto& voxels) {
                const auto& values = std::get<std::decay_t<decltype(voxels)>>(rest.voxels);
                std::copy(values.begin(), values.end(), voxels.begin());
            },
            target.voxels);
        return LiveDeformation(std::make_unique<Impl>(scan, std::move(target)));
    });
}

LiveDeformation::LiveDeformation(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
LiveDeformation::~LiveDeformation() = default;
LiveDeformation::LiveDeformation(LiveDeformation&&) noexcept = default;
LiveDeformation& LiveDeformation::operator=(LiveDeformation&&) noexcept = default;

Result<LiveUpdate> LiveDeformation::update() noexcept {
    return m_impl->update([&]() -> Result<bool> {
        if (const Status s = m_impl->tissue->update_deformation(); !s.ok()) return s.error();
        return true;
    });
}

Result<LiveUpdate> LiveDeformation::approach(std::int64_t max_elements) noexcept {
    return m_impl->update([&] { return m_impl->tissue->approach_deformation(max_elements); });
}

void LiveDeformation::start_over(const MovingScan& scan) noexcept {
    m_impl->tissue = &scan;
    m_impl->scatter.start_over(m_impl->volume, m_impl->inverse_mm.get());
}

const Volume& LiveDeformation::volume() const {
    return m_impl->volume;
}

bool LiveDeformation::keep_sources(bool keep) noexcept {
    if (keep == keeps_sources()) return keep;
    m_impl->inverse_mm.reset();
    if (!keep) return false;
    void* memory = std::calloc(voxel_count(m_impl->volume.grid), sizeof(Vec3f));
    if (!memory) return false;
    m_impl->inverse_mm.reset(static_cast<Vec3f*>(memory));
    m_impl->scatter.forget();
    // The tissue may be shown approximately.
    const auto rewrite = [&] { return m_impl->update([]() -> Result<bool> { return true; }); };
    if (rewrite()) return true;
    m_impl->inverse_mm.reset();
    (void)rewrite();  // after a failure the volume is behind until the next one
    return false;
}

bool LiveDeformation::keeps_sources() const {
    return m_impl->inverse_mm != nullptr;
}

Vec3f LiveDeformation::source_offset_mm(Vec3i voxel) const {
    return m_impl->inverse_mm[voxel_index(m_impl->volume.grid, voxel)];
}

const MovingScan& LiveDeformation::scan() const {
    return *m_impl->tissue;
}

void LiveDeformation::displacement_mm(const Box3i& box, std::span<float> values) const {
    m_impl->for_rows(box, values, [](const auto& rows) {
        rows([](Vec3i, Vec3f back) {
            return std::sqrt(back.x * back.x + back.y * back.y + back.z * back.z);
        });
    });
}

void LiveDeformation::jacobian(const Box3i& box, std::span<float> values) const {
    const Field& field = m_impl->tissue->deformation().field();
    const Vec3d s = field.grid().spacing_mm;
    const Mat3d axes = inverse(field.grid().direction);
    m_impl->for_rows(box, values, [&](const auto& rows) {
        SourceJacobian jacobian(field, m_impl->scatter.snapshot());
        rows([&](Vec3i p, Vec3f back) {
            if (back == Vec3f{0, 0, 0}) return 1.0F;
            const Vec3d way = axes * Vec3d{back.x, back.y, back.z};
            return float(jacobian.at({p.x + way.x / s.x, p.y + way.y / s.y, p.z + way.z / s.z}));
        });
    });
}

}  // namespace pliant
