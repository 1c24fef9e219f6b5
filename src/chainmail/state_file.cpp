// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/state_file.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <tuple>

#include "core/hash.h"

namespace pliant {
namespace {

constexpr unsigned char kMagic[8] = {0x89, 'P', 'L', 'S', 'T', 0x0d, 0x0a, 0x1a};
constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kCustomLaw = 1, kMaterialsChanged = 2,
                        kKnownFlags = kCustomLaw | kMaterialsChanged;
constexpr std::size_t kLengthAt = 16;
constexpr std::size_t kShortest = 24 + 8;
constexpr std::size_t kBricksPerPiece = 16;
/// Largest distance of elements from the scan's first one; no push reaches farther.
constexpr std::int64_t kFarthestElement = 1 << 24;

/// A checksum that is equal on big- and little-endian machines.
std::uint64_t checksum_of(std::span<const std::byte> bytes) {
    Hash64 hash;
    for (std::size_t at = 0; at < bytes.size(); at += 8) {
        std::uint64_t word = 0;
        for (std::size_t k = 0; k < 8 && at + k < bytes.size(); ++k)
            word |= std::uint64_t(bytes[at + k]) << 8 * k;
        hash.add_word(word);
    }
    return hash.value();
}

class Writer {
  public:
    void put(std::span<const std::byte> bytes) {
        m_out.insert(m_out.end(), bytes.begin(), bytes.end());
    }
    void put_u32(std::uint32_t value) {
        for (int k = 0; k < 4; ++k) m_out.push_back(std::byte(value >> 8 * k & 0xff));
    }
    void put_u64(std::uint64_t value) {
        put_u32(std::uint32_t(value));
        put_u32(std::uint32_t(value >> 32));
    }
    void put_vector(Vec3d v) {
        for (int a = 0; a < 3; ++a) put_u64(std::bit_cast<std::uint64_t>(v[a]));
    }
    void put_piece(std::span<const Vec3i> coords, const Bytes& raw) {
        put_u32(std::uint32_t(coords.size()));
        for (const Vec3i& coord : coords)
            for (int a = 0; a < 3; ++a) put_u32(std::uint32_t(coord[a]));
        const Bytes packed = pack(raw);
        put_u32(std::uint32_t(raw.size()));
        put_u32(std::uint32_t(packed.size()));
        put(packed);
    }
    Bytes finish() {
        const std::uint64_t length = m_out.size() + 8;
        for (std::size_t k = 0; k < 8; ++k)
            m_out[kLengthAt + k] = std::byte(length >> 8 * k & 0xff);
        put_u64(checksum_of(m_out));
        return std::move(m_out);
    }

  private:
    Bytes m_out;
};

bool comes_first(Vec3i p, Vec3i q) {
    return std::tie(p.z, p.y, p.x) < std::tie(q.z, q.y, q.x);
}

void put_fingerprint(Writer& out, const ScanFingerprint& scan) {
    for (int a = 0; a < 3; ++a) out.put_u32(std::uint32_t(scan.grid.size[a]));
    out.put_u32(scan.is_16_bit ? 1 : 0);
    out.put_vector(scan.grid.spacing_mm);
    out.put_vector(scan.grid.origin_mm);
    for (const Vec3d& column : scan.grid.direction.columns) out.put_vector(column);
    out.put_u64(scan.voxel_hash);
}

void put_imprints(Writer& out, const Lattice& lattice, const PlasticRest& imprints) {
    const std::vector<Fixed> none(std::size_t(lattice.elements_per_brick()), 0);
    const Components before{none.data(), none.data(), none.data()};
    std::vector<Vec3i> coords;
    for (const auto& entry : imprints.bricks()) coords.push_back(entry.first);
    std::sort(coords.begin(), coords.end(), comes_first);
    for (std::size_t first = 0; first < coords.size(); first += kBricksPerPiece) {
        const auto piece =
            std::span(coords).subspan(first, std::min(kBricksPerPiece, coords.size() - first));
        Bytes raw;
        for (const Vec3i& coord : piece) {
            const auto& imprint = imprints.find(coord)->imprint;
            encode_change(before, {imprint[0].data(), imprint[1].data(), imprint[2].data()},
                          lattice.brick_size(), raw);
        }
        out.put_piece(piece, raw);
    }
    out.put_u32(0);
}

void put_moves(Writer& out, const Lattice& lattice) {
    const std::vector<Fixed> rest(std::size_t(lattice.elements_per_brick()), 0);
    const Components before{rest.data(), rest.data(), rest.data()};
    std::vector<Vec3i> coords;
    Bytes raw;
    const auto finish = [&] {
        if (!coords.empty()) out.put_piece(coords, raw);
        coords.clear();
        raw.clear();
    };
    for (const int index : lattice.resident_bricks()) {
        const Brick& brick = lattice.brick(index);
        if (!encode_change(before, {brick.u[0], brick.u[1], brick.u[2]}, lattice.brick_size(), raw))
            continue;
        coords.push_back(brick.coord);
        if (coords.size() == kBricksPerPiece) finish();
    }
    finish();
    out.put_u32(0);
}

void put_edits(Writer& out, const Lattice& lattice) {
    std::vector<Vec3i> coords;
    for (const auto& entry : lattice.all_edits()) coords.push_back(entry.first);
    std::sort(coords.begin(), coords.end(), comes_first);
    for (std::size_t first = 0; first < coords.size(); first += kBricksPerPiece) {
        const auto piece =
            std::span(coords).subspan(first, std::min(kBricksPerPiece, coords.size() - first));
        Bytes raw;
        for (const Vec3i& coord : piece)
            for (const std::uint8_t flags : *lattice.edits_of(coord))
                raw.push_back(std::byte(flags));
        out.put_piece(piece, raw);
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
    Writer out;
    out.put(std::as_bytes(std::span(kMagic)));
    out.put_u32(kVersion);
    out.put_u32((header.custom_law ? kCustomLaw : 0) |
                (header.materials_changed ? kMaterialsChanged : 0));
    out.put_u64(0);  // placeholder for the length
    put_fingerprint(out, header.scan);
    out.put_u64(header.label_hash);
    out.put_u32(std::uint32_t(header.settings.size()));
    out.put(std::as_bytes(std::span(header.settings)));
    put_moves(out, lattice);
    put_edits(out, lattice);
    put_imprints(out, lattice, imprints);
    return out.finish();
}

Error StateReader::damaged() const {
    return {ErrorCode::Unreadable, m_name + ": expected a saved state, found one that is damaged"};
}

bool StateReader::take(std::size_t count, std::span<const std::byte>& out) {
    if (m_bytes.size() < count) return false;
    out = m_bytes.first(count);
    m_bytes = m_bytes.subspan(count);
    return true;
}
bool StateReader::take_u32(std::uint32_t& value) {
    std::span<const std::byte> bytes;
    if (!take(4, bytes)) return false;
    value = 0;
    for (std::size_t k = 0; k < 4; ++k) value |= std::uint32_t(bytes[k]) << 8 * k;
    return true;
}
bool StateReader::take_u64(std::uint64_t& value) {
    std::uint32_t low = 0, high = 0;
    if (!take_u32(low) || !take_u32(high)) return false;
    value = low | std::uint64_t(high) << 32;
    return true;
}
bool StateReader::take_vector(Vec3d& v) {
    for (int a = 0; a < 3; ++a) {
        std::uint64_t bits = 0;
        if (!take_u64(bits)) return false;
        v[a] = std::bit_cast<double>(bits);
    }
    return true;
}

bool StateReader::take_fingerprint(ScanFingerprint& scan) {
    for (int a = 0; a < 3; ++a) {
        std::uint32_t size = 0;
        if (!take_u32(size)) return false;
        scan.grid.size[a] = std::int32_t(size);
    }
    std::uint32_t is_16_bit = 0;
    bool whole = take_u32(is_16_bit) && take_vector(scan.grid.spacing_mm) &&
                 take_vector(scan.grid.origin_mm);
    for (Vec3d& column : scan.grid.direction.columns) whole = whole && take_vector(column);
    scan.is_16_bit = is_16_bit == 1;
    return whole && take_u64(scan.voxel_hash);
}

Result<StateHeader> StateReader::read_header() {
    const std::span<const std::byte> all = m_bytes;
    std::span<const std::byte> magic, text;
    std::uint32_t version = 0, flags = 0, settings_length = 0;
    std::uint64_t length = 0;
    if (!take(sizeof kMagic, magic) || std::memcmp(magic.data(), kMagic, sizeof kMagic) != 0)
        return Error{ErrorCode::Unreadable,
                     m_name + ": expected a state that Pliant saved, found another kind of file"};
    if (!take_u32(version)) return damaged();
    if (version > kVersion)
        return Error{ErrorCode::Unsupported, m_name + ": expected a state of version " +
                                                 std::to_string(kVersion) + ", found version " +
                                                 std::to_string(version) +
                                                 " of a newer Pliant, or damage"};
    if (version == 0 || !take_u32(flags) || !take_u64(length) || length < kShortest)
        return damaged();
    if (length != all.size())
        return Error{ErrorCode::Unreadable, m_name + ": expected " + std::to_string(length) +
                                                " bytes, found " + std::to_string(all.size())};
    Bytes end(all.end() - 8, all.end());
    std::uint64_t checksum = 0;
    for (std::size_t k = 0; k < 8; ++k) checksum |= std::uint64_t(end[k]) << 8 * k;
    if (checksum_of(all.first(all.size() - 8)) != checksum || (flags & ~kKnownFlags))
        return damaged();
    m_bytes = m_bytes.first(m_bytes.size() - 8);
    StateHeader header;
    header.custom_law = flags & kCustomLaw;
    header.materials_changed = flags & kMaterialsChanged;
    if (!take_fingerprint(header.scan) || !take_u64(header.label_hash) ||
        !take_u32(settings_length) || !take(settings_length, text))
        return damaged();
    header.settings.assign(reinterpret_cast<const char*>(text.data()), text.size());
    return header;
}

Result<std::optional<StateReader::Piece>> StateReader::read_piece(std::size_t raw_limit) {
    std::uint32_t count = 0, raw_size = 0, packed_size = 0;
    std::span<const std::byte> packed;
    if (!take_u32(count)) return damaged();
    if (count == 0) return std::optional<Piece>();
    if (count > m_bytes.size() / sizeof(Vec3i)) return damaged();
    Piece piece;
    for (std::uint32_t n = 0; n < count; ++n) {
        Vec3i coord{};
        for (int a = 0; a < 3; ++a) {
            std::uint32_t word = 0;
            if (!take_u32(word)) return damaged();
            coord[a] = std::int32_t(word);
        }
        piece.coords.push_back(coord);
    }
    if (!take_u32(raw_size) || !take_u32(packed_size) || !take(packed_size, packed))
        return damaged();
    if (raw_size > longest_unpacked(packed_size) || raw_size > raw_limit * count) return damaged();
    piece.raw.resize(raw_size);
    if (!unpack(packed, piece.raw)) return damaged();
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
                             m_name +
                                 ": more elements moved than [lattice] max_elements allows; "
                                 "expected a larger setting"};
            if (!follows(coord, lattice) ||
                !decode_change(raw, lattice.brick_size(),
                               {change.data(), change.data() + n, change.data() + 2 * n}))
                return damaged();
            if (!write(coord, change)) return damaged();
        }
        if (!raw.empty()) return damaged();
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
        if ((*piece)->raw.size() != n * (*piece)->coords.size()) return damaged();
        auto at = (*piece)->raw.begin();
        for (const Vec3i& coord : (*piece)->coords) {
            BrickEdits edits(n);
            for (std::uint8_t& flags : edits) flags = std::uint8_t(*at++);
            const bool known =
                std::all_of(edits.begin(), edits.end(), [](auto f) { return f < 16; });
            if (--max_bricks < 0 || !known || !follows(coord, lattice)) return damaged();
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
    if (!m_bytes.empty()) return damaged();
    return Ok{};
}

}  // namespace pliant
