// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The public interface of saving and loading. A loaded state is built and checked beside the
// present one, which is replaced once nothing can fail any more.

#include <pliant/core/files.h>
#include <pliant/core/output_file.h>

#include "base/errors.h"
#include "base/hash.h"
#include "base/text.h"
#include "chainmail/chainmail_impl.h"
#include "chainmail/state_file.h"
#include "field/cell_block.h"
#include "material/settings.h"

namespace pliant {
namespace {

Status check_scan(const std::string& name, const ScanFingerprint& own,
                  const ScanFingerprint& found) {
    const auto other = [&](const std::string& what) -> Status {
        return Error{ErrorCode::InvalidArgument,
                     name + ": expected a state of this scan, found one of another: " + what};
    };
    if (own.grid.size != found.grid.size)
        return other("of " + text_of_size(found.grid.size) + " voxels instead of " +
                     text_of_size(own.grid.size));
    if (own.grid.spacing_mm != found.grid.spacing_mm)
        return other("with a spacing of " + text_of(found.grid.spacing_mm) + " mm instead of " +
                     text_of(own.grid.spacing_mm));
    if (own.grid.origin_mm != found.grid.origin_mm)
        return other("with its origin at " + text_of(found.grid.origin_mm) + " mm instead of " +
                     text_of(own.grid.origin_mm));
    if (own.grid != found.grid) return other("with other directions");
    if (own != found) return other("with other voxel values");
    return Ok{};
}

/// Hash of the label materials, which the settings' text doesn't include. @returns 0 without label
/// materials
std::uint64_t hash_label_materials(const ChainMailSettings& settings) {
    if (settings.label_materials.empty()) return 0;
    Hash64 hash;
    const auto add_numbers = [&](Vec3d v) {
        const double numbers[] = {v.x, v.y, v.z};
        hash.add(std::span<const double>(numbers));
    };
    for (const LabelMaterial& label : settings.label_materials) {
        hash.add(std::span<const int>(label.values));
        for (const auto& number :
             {label.offset, label.bone_threshold_hu, label.max_movement_mm, label.yield})
            add_numbers({number ? 1.0 : 0.0, number.value_or(0), 0});
        for (const Vec3d& v : {label.factor, label.compress, label.stretch, label.shear})
            add_numbers(v);
        hash.add_word(std::uint64_t(label.law) * 2 + label.along_direction);
    }
    if (settings.labels) hash.add_word(fingerprint_of(*settings.labels).voxel_hash);
    if (settings.directions) hash.add(std::span<const Vec3f>(settings.directions->vectors_mm));
    return hash.value();
}

bool link_holds(const HalfLimits& low, const HalfLimits& high, Vec3<Fixed> u, Vec3<Fixed> v,
                int b) {
    for (int a = 0; a < 3; ++a) {
        const std::int64_t difference = std::int64_t(v[a]) - u[a];
        const bool stretch = a == b;
        const std::int64_t most = stretch ? std::int64_t(low.stretch[b]) + high.stretch[b]
                                          : std::int64_t(low.shear[b]) + high.shear[b];
        const std::int64_t least = stretch ? std::int64_t(low.compress[b]) + high.compress[b]
                                           : std::int64_t(low.shear[b]) + high.shear[b];
        if (difference > most || difference < -least) return false;
    }
    return true;
}

const char* fault_of_element(const HalfLimits& half, bool is_void, Vec3<Fixed> u) {
    if (u == Vec3<Fixed>{0, 0, 0}) return "";
    if (is_void) return "an element that isn't there has moved";
    if (half.fixed) return "a fixed element has moved";
    const Vec3d away{double(u.x), double(u.y), double(u.z)};
    const double limit = half.max_movement;
    return dot(away, away) > limit * limit
               ? "an element is farther from its rest position than allowed"
               : "";
}

const char* fault_of_block(const Lattice& lattice, const CellBlock& block) {
    const Vec3i first = block.first_element();
    const auto limits = [&](Vec3i e) -> const HalfLimits& {
        return lattice.materials()[lattice.material_at(e)];
    };
    for (int z = 0; z < block.size(); ++z)
        for (int y = 0; y < block.size(); ++y)
            for (int x = 0; x < block.size(); ++x) {
                const int n = block.index(x, y, z);
                if (!block.is_touched(n)) continue;
                const Vec3i e = first + Vec3i{x, y, z};
                const Vec3<Fixed> u = block.displacement(n);
                const char* fault = fault_of_element(limits(e), lattice.is_void(e), u);
                if (*fault) return fault;
                for (int b = 0; b < 3; ++b) {
                    const Vec3i f = e + Vec3i{b == 0, b == 1, b == 2};
                    const Vec3<Fixed> v =
                        block.displacement(block.index(x + (b == 0), y + (b == 1), z + (b == 2)));
                    if (u == v || !lattice.is_linked(e, b)) continue;
                    if (!link_holds(limits(e), limits(f), u, v, b))
                        return "a link is outside of its limits";
                }
            }
    return "";
}

}  // namespace

Status ChainMail::save_state(const std::filesystem::path& path) const {
    return attempt([&] { return m_impl->save_state(path); });
}

Status ChainMail::load_state(const std::filesystem::path& path) {
    return attempt([&]() -> Status {
        auto loaded = m_impl->load_state(path);
        if (!loaded.ok()) return loaded.error();
        m_impl = std::move(*loaded);
        return Ok{};
    });
}

Status ChainMail::Impl::save_state(const std::filesystem::path& path) const {
    const StateHeader header{.scan = fingerprint_of(volume),
                             .custom_law = bool(settings.custom_law),
                             .materials_changed = materials_changed,
                             .label_hash = hash_label_materials(settings),
                             .settings = settings_text(settings)};
    const Bytes bytes = encode_state(header, lattice, plastic_rest);
    StagedFiles files;
    const auto staged = files.stage(path);
    if (!staged.ok()) return staged.error();
    OutputFile file(*staged, path.string());
    file.write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (const Status s = file.close(); !s.ok()) return s;
    return files.commit();
}

Result<std::unique_ptr<ChainMail::Impl>> ChainMail::Impl::load_state(
    const std::filesystem::path& path) const {
    const std::string name = path.string();
    if (history.depth() > (held.empty() ? 0 : 1))
        return Error{ErrorCode::InvalidArgument,
                     name + ": expected no open group of steps, found one; end it first"};
    const auto bytes = read_small_file(path, std::string::npos, "a saved state");
    if (!bytes.ok()) return bytes.error();
    auto opened = StateReader::open(name, std::as_bytes(std::span(*bytes)));
    if (!opened.ok()) return opened.error();
    StateReader& reader = *opened;
    const auto header = reader.read_header();
    if (!header.ok()) return header.error();
    const Status scan = check_scan(name, fingerprint_of(volume), header->scan);
    if (!scan.ok()) return scan.error();
    auto loaded = parse_settings(name, header->settings);
    if (!loaded.ok()) return loaded.error();
    if (header->custom_law && !settings.custom_law)
        return Error{
            ErrorCode::InvalidArgument,
            name + ": was saved with a material law of its own; expected the same law here"};
    if (header->custom_law) loaded->custom_law = settings.custom_law;
    loaded->solver = settings.solver;
    if (header->label_hash != hash_label_materials(settings))
        return Error{ErrorCode::InvalidArgument,
                     name +
                         ": was saved with other label materials; expected the same [[label]] "
                         "tables, labels and directions here"};
    loaded->label_materials = settings.label_materials;
    loaded->labels = settings.labels;
    loaded->directions = settings.directions;
    auto materials = make_materials(volume, *loaded);
    if (!materials.ok())
        return Error{materials.error().code, name + ": " + materials.error().message};
    auto impl = std::make_unique<Impl>(volume, *loaded, std::move(*materials), arena);
    impl->lattice.continue_clock(lattice.clock());
    impl->lattice.tick();
    const Status read =
        reader.read_lattice(impl->lattice, impl->plastic_rest, settings.max_elements);
    if (!read.ok()) return read.error();
    impl->materials_changed = header->materials_changed;
    impl->restore_allowance();
    if (!header->materials_changed) {
        std::string fault = find_fault(impl->lattice, arena);
        if (fault.empty()) fault = find_imprint_fault(impl->lattice, impl->plastic_rest);
        if (!fault.empty())
            return Error{ErrorCode::Unreadable,
                         name + ": expected displacements within all limits, but " + fault};
    }
    return impl;
}

// Whether displacements from a file can result from pushes: in whole numbers, with the limits of
// the solvers.

std::string find_fault(const Lattice& lattice, const TaskArena& arena) {
    const std::vector<Vec3i> coords = cell_blocks(lattice);
    std::vector<const char*> faults(coords.size(), "");
    arena.for_each(std::int64_t(coords.size()), 4, [&](std::int64_t begin, std::int64_t end) {
        CellBlock block;
        for (auto k = std::size_t(begin); k < std::size_t(end); ++k) {
            block.load(lattice, coords[k]);
            faults[k] = fault_of_block(lattice, block);
        }
    });
    const auto found = std::find_if(faults.begin(), faults.end(), [](auto* text) { return *text; });
    return found == faults.end() ? "" : *found;
}

std::string find_imprint_fault(const Lattice& lattice, const PlasticRest& imprints) {
    const auto limits = [&](Vec3i e) -> const HalfLimits& {
        return lattice.materials()[lattice.material_at(e)];
    };
    for (const auto& [coord, brick] : imprints.bricks())
        for (int n = 0; n < lattice.elements_per_brick(); ++n) {
            const Vec3i e = lattice.element_of(coord, n);
            const auto k = std::size_t(n);
            const Vec3<Fixed> p{brick.imprint[0][k], brick.imprint[1][k], brick.imprint[2][k]};
            if (p == Vec3<Fixed>{0, 0, 0}) continue;
            if (lattice.is_void(e)) return "an element that isn't there has an imprint";
            if (limits(e).fixed) return "a fixed element has an imprint";
            for (int side = 0; side < 6; ++side) {
                const int b = side / 2;
                Vec3i f = e;
                f[b] += side % 2 ? 1 : -1;
                const Vec3<Fixed> q = imprints.imprint_at(lattice, f);
                const bool up = side % 2;
                if (p == q || !lattice.is_linked(up ? e : f, b)) continue;
                if (!link_holds(limits(up ? e : f), limits(up ? f : e), up ? p : q, up ? q : p, b))
                    return "an imprint is outside of a link's limits";
            }
        }
    return "";
}

}  // namespace pliant
