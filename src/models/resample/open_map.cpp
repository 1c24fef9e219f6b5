// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/open_map.h"

#include <algorithm>
#include <cstring>
#include <new>

#include "resample/scatter_job.h"

namespace pliant {
namespace {

template <class T, class Free>
void allocate_zeros(std::size_t count, std::unique_ptr<T[], Free>& to) {
    to.reset(static_cast<T*>(std::calloc(count, sizeof(T))));
    if (!to) throw std::bad_alloc();
}

}  // namespace

OpenMap::OpenMap(const Grid& scan) : m_voxel_count(scan.size) {
    allocate_zeros(voxel_count(scan), m_open);
}

void OpenMap::set_brick_size(int size) {
    if (size == m_size) return;
    m_size = 0;  // until memory is allocated
    for (int a = 0; a < 3; ++a) m_brick_count[a] = (m_voxel_count[a] + size - 1) / size;
    const std::size_t bricks = dense_count(m_brick_count);
    m_words_per_brick = std::size_t(BitLayout<int>{size}.words());
    allocate_zeros(bricks * m_words_per_brick, m_bits);
    m_states.assign(bricks, State::AsScan);
    m_size = size;
}

Box3i OpenMap::box_of(std::size_t brick) const {
    const Vec3i n = m_brick_count, size{m_size, m_size, m_size};
    const auto index = int(brick);
    const Vec3i first = m_size * Vec3i{index % n.x, index / n.x % n.y, index / (n.x * n.y)};
    return overlap({first, first + size}, {{0, 0, 0}, m_voxel_count});
}

void OpenMap::close(const Box3i& box) {
    for_each_row(box, [&](Vec3i p) {
        std::memset(m_open.get() + dense_index(p, m_voxel_count), int(Open::Never),
                    std::size_t(box.end.x - box.begin.x));
    });
}

void OpenMap::close_all_but(std::span<const std::uint8_t> dirty) {
    for (const std::size_t brick : m_open_bricks) {
        if (dirty[brick]) continue;
        close(box_of(brick));
        m_states[brick] = State::Changed;
    }
    m_open_bricks.clear();
}

void OpenMap::close_all(std::span<const std::uint8_t> bricks) {
    for_boxes(bricks, [&](const Box3i& box) { close(box); });
    std::fill(m_states.begin(), m_states.end(), State::AsScan);
    m_open_bricks.clear();
}

}  // namespace pliant
