// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/state_file.h"

#include <algorithm>
#include <cstring>
#include <tuple>

#include "base/hash.h"

namespace pliant {
namespace {

constexpr std::uint32_t kCustomLaw = 1, kMaterialsChanged = 2,
                        kKnownFlags = kCustomLaw | kMaterialsChanged;
constexpr std::size_t kBricksPerRecord = 16;
/// Largest distance of elements from the scan's first one; no push reaches farther.
constexpr std::int64_t kFarthestElement = 1 << 24;

void put_piece(StateWriter& out, std::span<const Vec3i> coords, const Bytes& raw) {
    out.put_u32(std::uint32_t(coords.size()));
    for (const Vec3i& coord : coords)
        for (int a = 0; a < 3; ++a) out.put_u32(std::uint32_t(coord[a]));
    const Bytes packed = pack(raw);
    out.put_u32(std::uint32_t(raw.size()));
    out.put_u32(std::uint32_t(packed.size()));
    out.put(packed);
}

bool comes_first(Vec3i p, Vec3i q) {
    return std::tie(p.z, p.y, p.x) < std::tie(q.z, q.y, q.x);
}

void put_fingerprint(StateWriter& out, const ScanFingerprint& scan) {
    for (int a = 0; a < 3; ++a) out.put_u32(std::uint32_t(scan.grid.size[a]));
    out.put_u32(scan.is_16_bit ? 1 : 0);
    out.put_vector(scan.grid.spacing_mm);
    out.put_vector(scan.grid.origin_mm);
    for (const Vec3d& column : scan.grid.direction.columns) out.put_vector(column);
    out.put_u64(scan.voxel_hash);
}

void put_imprints(StateWriter& out, const Lattice& lattice, const PlasticRest& imprints) {
    const std::vector<Fixed> none(std::size_t(lattice.elements_per_brick()), 0);
    const Components before{none.data(), none.data(), none.data()};
    std::vector<Vec3i> coords;
    for (const auto& entry : imprints.bricks()) coords.push_back(entry.first);
    std::sort(coords.begin(), coords.end(), comes_first);
    for (std::size_t first = 0; first < coords.size(); first += kBricksPerRecord) {
        const auto piece =
            std::span(coords).subspan(first, std::min(kBricksPerRecord, coords.size() - first));
        Bytes raw;
        for (const Vec3i& coord : piece) {
            const auto& imprint = imprints.find(coord)->imprint;
            encode_change(before, {imprint[0].data(), imprint[1].data(), imprint[2].data()},
                          lattice.brick_size(), raw);
        }
        put_piece(out, piece, raw);
    }
    out.put_u32(0);
}

void put_moves(StateWriter& out, const Lattice& lattice) {
    const std::vector<Fixed> rest(std::size_t(lattice.elements_per_brick()), 0);
    const Components before{rest.data(), rest.data(), rest.data()};
    std::vector<Vec3i> coords;
    Bytes raw;
    const auto finish = [&] {
        if (!coords.empty()) put_piece(out, coords, raw);
        coords.clear();
        raw.clear();
    };
    for (const int index : lattice.resident_bricks()) {
        const Brick& brick = lattice.brick(index);
        if (!encode_change(before, {brick.u[0], brick.u[1], brick.u[2]}, lattice.brick_size(), raw))
            continue;
        coords.push_back(brick.coord);
        if (coords.size() == kBricksPerRecord) finish();
    }
    finish();
    out.put_u32(0);
}

void put_edits(StateWriter& out, const Lattice& lattice) {
    std::vector<Vec3i> coords;
    for (const auto& entry : lattice.all_edits()) coords.push_back(entry.first);
    std::sort(coords.begin(), coords.end(), comes_first);
    for (std::size_t first = 0; first < coords.size(); first += kBricksPerRecord) {
        const auto piece =
            std::span(coords).subspan(first, std::min(kBricksPerRecord, coords.size() - first));
        Bytes raw;
        for (const Vec3i& coord : piece)
            for (const std::uint8_t flags : *lattice.edits_of(coord))
                raw.push_back(std::byte(flags));
        put_piece(out, piece, raw);
    }
    out.put_u32(0);
}

}  // namespace

ScanFingerprint fingerprint_of(const Volume& volume) {
    Hash64 hash;
    std::visit([&](const auto& voxels) { hash.add(std::span(voxels.data(), voxels.size())); },
               volume.voxels);
    return {volume.grid, volume.is_16_bit(), hash.value()};
}

Bytes encode_state(const StateHeader& header, const Lattice& lattice, const PlasticRest& imprints) {
    StateWriter out((header.custom_law ? kCustomLaw : 0) |
                    (header.materials_changed ? kMaterialsChanged : 0));
    put_fingerprint(out, header.scan);
    out.put_u64(header.label_hash);
    out.put_u32(std::uint32_t(header.settings.size()));
    out.put(std::as_bytes(std::span(header.settings)));
    put_moves(out, lattice);
    put_edits(out, lattice);
    put_imprints(out, lattice, imprints);
    return out.finish();
}

Result<StateReader> StateReader::open(std::string name, std::span<const std::byte> file) {
    auto frame = StateParser::open(std::move(name), file, kKnownFlags | kStateOfNumbers);
    if (!frame.ok()) return frame.error();
    if (frame->flags() & kStateOfNumbers)
        return Error{
            ErrorCode::InvalidArgument,
            frame->name() + ": expected a state of ChainMail, found that of another tissue"};
    return StateReader(std::move(*frame));
}

bool StateReader::take_fingerprint(ScanFingerprint& scan) {
    for (int a = 0; a < 3; ++a) {
        std::uint32_t size = 0;
        if (!m_frame.take_u32(size)) return false;
        scan.grid.size[a] = std::int32_t(size);
    }
    std::uint32_t is_16_bit = 0;
    bool whole = m_frame.take_u32(is_16_bit) && m_frame.take_vector(scan.grid.spacing_mm) &&
                 m_frame.take_vector(scan.grid.origin_mm);
    for (Vec3d& column : scan.grid.direction.columns) whole = whole && m_frame.take_vector(column);
    scan.is_16_bit = is_16_bit == 1;
    return whole && m_frame.take_u64(scan.voxel_hash);
}

Result<StateHeader> StateReader::read_header() {
    std::uint32_t settings_length = 0;
    std::span<const std::byte> text;
    StateHeader header;
    header.custom_law = m_frame.flags() & kCustomLaw;
    header.materials_changed = m_frame.flags() & kMaterialsChanged;
    if (!take_fingerprint(header.scan) || !m_frame.take_u64(header.label_hash) ||
        !m_frame.take_u32(settings_length) || !m_frame.take(settings_length, text))
        return m_frame.damaged();
    header.settings.assign(reinterpret_cast<const char*>(text.data()), text.size());
    return header;
}

Result<std::optional<StateReader::Piece>> StateReader::read_piece(std::size_t raw_limit) {
    std::uint32_t count = 0, raw_size = 0, packed_size = 0;
    std::span<const std::byte> packed;
    if (!m_frame.take_u32(count)) return m_frame.damaged();
    if (count == 0) return std::optional<Piece>();
    if (count > m_frame.left() / sizeof(Vec3i)) return m_frame.damaged();
    Piece piece;
    for (std::uint32_t n = 0; n < count; ++n) {
        Vec3i coord{};
        for (int a = 0; a < 3; ++a) {
            std::uint32_t word = 0;
            if (!m_frame.take_u32(word)) return m_frame.damaged();
            coord[a] = std::int32_t(word);
        }
        piece.coords.push_back(coord);
    }
    if (!m_frame.take_u32(raw_size) || !m_frame.take_u32(packed_size) ||
        !m_frame.take(packed_size, packed))
        return m_frame.damaged();
    if (raw_size > longest_unpacked(packed_size) || raw_size > raw_limit * count)
        return m_frame.damaged();
    piece.raw.resize(raw_size);
    if (!unpack(packed, piece.raw)) return m_frame.damaged();
    return std::optional<Piece>(std::move(piece));
}

bool StateReader::follows(Vec3i coord, const Lattice& lattice) {
    if (m_last && std::tie(coord.z, coord.y, coord.x) <= std::tie(m_last->z, m_last->y, m_last->x))
        return false;
    m_last = coord;
    const std::int64_t farthest = kFarthestElement / lattice.brick_size();
    return coord.x >= -farthest && coord.x <= farthest && coord.y >= -farthest &&
           coord.y <= farthest && coord.z >= -farthest && coord.z <= farthest;
}

template <class Write>
Status StateReader::read_changes(const Lattice& lattice, std::int64_t max_bricks,
                                 const Write& write) {
    const auto n = std::size_t(lattice.elements_per_brick());
    std::vector<std::uint32_t> change(3 * n);
    m_last.reset();
    for (;;) {
        const auto piece = read_piece(2 + 12 * n);
        if (!piece.ok()) return piece.error();
        if (!*piece) return Ok{};
        std::span<const std::byte> raw = (*piece)->raw;
        for (const Vec3i& coord : (*piece)->coords) {
            if (--max_bricks < 0)
                return Error{ErrorCode::LimitExceeded,
                             m_frame.name() +
                                 ": more elements moved than [lattice] max_elements allows; "
                                 "expected a larger setting"};
            if (!follows(coord, lattice) ||
                !decode_change(raw, lattice.brick_size(),
                               {change.data(), change.data() + n, change.data() + 2 * n}))
                return m_frame.damaged();
            if (!write(coord, change)) return m_frame.damaged();
        }
        if (!raw.empty()) return m_frame.damaged();
    }
}

Status StateReader::read_moves(Lattice& lattice, std::int64_t max_bricks) {
    const auto n = std::size_t(lattice.elements_per_brick());
    return read_changes(lattice, max_bricks, [&](Vec3i coord, const auto& change) {
        const int index = lattice.ensure_brick(coord);
        for (std::size_t a = 0; a < 3; ++a)
            std::memcpy(lattice.brick(index).u[a], change.data() + a * n, n * sizeof(Fixed));
        lattice.brick(index).changed_at = lattice.clock();
        lattice.update_bounds(index);
        return true;
    });
}

Status StateReader::read_imprints(const Lattice& lattice, PlasticRest& imprints,
                                  std::int64_t max_bricks) {
    const auto n = std::size_t(lattice.elements_per_brick());
    constexpr auto kFarthest = std::int64_t(kMaxMovementMm * kUnitsPerMm);
    return read_changes(lattice, max_bricks, [&](Vec3i coord, const auto& change) {
        Imprint imprint;
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t k = a * n; k < (a + 1) * n; ++k) {
                const auto p = Fixed(change[k]);
                if (p < -kFarthest || p > kFarthest) return false;
                imprint[a].push_back(p);
            }
        imprints.set(lattice, coord, std::move(imprint));
        return true;
    });
}

Status StateReader::read_edits(Lattice& lattice, std::int64_t max_bricks) {
    const auto n = std::size_t(lattice.elements_per_brick());
    m_last.reset();
    for (;;) {
        const auto piece = read_piece(n);
        if (!piece.ok()) return piece.error();
        if (!*piece) return Ok{};
        if ((*piece)->raw.size() != n * (*piece)->coords.size()) return m_frame.damaged();
        auto at = (*piece)->raw.begin();
        for (const Vec3i& coord : (*piece)->coords) {
            BrickEdits edits(n);
            for (std::uint8_t& flags : edits) flags = std::uint8_t(*at++);
            const bool known =
                std::all_of(edits.begin(), edits.end(), [](auto f) { return f < 16; });
            if (--max_bricks < 0 || !known || !follows(coord, lattice)) return m_frame.damaged();
            lattice.set_edits(coord, std::move(edits));
        }
    }
}

Status StateReader::read_lattice(Lattice& lattice, PlasticRest& imprints,
                                 std::int64_t max_elements) {
    const std::int64_t max_bricks = max_elements / lattice.elements_per_brick() + 8;
    if (const Status moves = read_moves(lattice, max_bricks); !moves.ok()) return moves;
    if (const Status edits = read_edits(lattice, max_bricks); !edits.ok()) return edits;
    if (const Status read = read_imprints(lattice, imprints, max_bricks); !read.ok()) return read;
    if (m_frame.left() > 0) return m_frame.damaged();
    return Ok{};
}

}  // namespace pliant
