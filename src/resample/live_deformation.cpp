// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/resample.h>

#include <chrono>

#include "resample/scatter.h"

namespace pliant {

struct LiveDeformation::Impl {
    explicit Impl(const ChainMail& t)
        : tissue(t), volume(t.volume()), scatter(t.volume(), t.arena()) {}

    const ChainMail& tissue;
    Volume volume;
    Scatter scatter;
};

LiveDeformation::LiveDeformation(const ChainMail& tissue)
    : m_impl(std::make_unique<Impl>(tissue)) {}
LiveDeformation::~LiveDeformation() = default;
LiveDeformation::LiveDeformation(LiveDeformation&&) noexcept = default;
LiveDeformation& LiveDeformation::operator=(LiveDeformation&&) noexcept = default;

LiveUpdate LiveDeformation::update() {
    const auto start = std::chrono::steady_clock::now();
    const Lattice& lattice = m_impl->tissue.lattice();
    Scatter& scatter = m_impl->scatter;
    LiveUpdate update;
    const OpenVoxels open = scatter.look(lattice, Mapping::Cells, m_impl->volume);
    update.gap_voxels = scatter.write(lattice, Mapping::Cells, m_impl->volume, nullptr, {});
    update.written_voxels = open.count;
    update.dirty_box = open.box;
    update.boxes = scatter.written_boxes();
    update.resample_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return update;
}

const Volume& LiveDeformation::volume() const {
    return m_impl->volume;
}

}  // namespace pliant
