// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "session/source.h"

#include <pliant/core/files.h>
#include <pliant/models/network_file.h>
#include <pliant/models/organs.h>
#include <pliant/models/scene_files.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "base/errors.h"
#include "base/hash.h"
#include "base/record_toml.h"
#include "mesh/mean_edge.h"
#include "protocol/limits.h"

namespace pliant::serve {
namespace {

constexpr double kOrganWindow_hu = 400, kOrganLevel_hu = 40;  ///< of soft tissue
constexpr double kToolEdges = 1.5;  ///< radius of a tool in mean edges of a mesh

/// Practically unlimited: memory bounds the history.
constexpr int kHistorySteps = 100'000;

std::string value_of(const KeyValues& pairs, const std::string& key) {
    for (const auto& [name, value] : pairs)
        if (name == key) return value;
    return {};
}

std::optional<double> number_of(const KeyValues& pairs, const std::string& key) {
    const std::string text = value_of(pairs, key);
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (text.empty() || error != std::errc{} || !std::isfinite(number)) return {};
    return number;
}

template <class Values>
void find_range(const Values& values, VolumeInfo& info) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    info.lowest_hu = double(*low);
    info.highest_hu = double(*high);
}

/// View from the end of the guide, half-way between the catheter and the wall.
Endoscope beside_guide(const CatheterEntry& entry, const VesselWall& wall) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3d& p : wall.ghost.nodes_mm)
        nearest = std::min(nearest, norm(p - entry.position_mm));
    const Vec3d ahead = normalized(entry.direction);
    const Vec3d other = std::abs(ahead.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    const Vec3d side = normalized(cross(ahead, other));
    return {.eye_mm = entry.position_mm + 0.6 * nearest * side, .look = ahead};
}

/// @returns NotFound, or one line that names the file and the key
Result<LoadedScan> load_vessel(const SceneSource& source, const TaskArena& arena) {
    const auto file = read_vessel_file(source.file);
    if (!file.ok()) return file.error();
    auto made = make_vessel(*file, arena);
    if (!made.ok()) return made.error();
    LoadedScan loaded;
    if (made->scan) {
        loaded.volume = *std::exchange(made->scan, {});
        // The lumen is brighter than the wall.
        loaded.iso_hu = file->low_hu;
        loaded.polarity = Polarity::Falling;
    } else {
        auto scan = scan_of_vessel(made->wall, arena);
        if (!scan.ok()) return Error{scan.error().code, source.file + ": " + scan.error().message};
        loaded.volume = std::move(*scan);
    }
    loaded.info.start = beside_guide(made->settings.entry, made->wall);
    loaded.info.name = std::filesystem::path(source.file).stem().string();
    loaded.vessel = std::make_shared<const MadeVessel>(std::move(*made));
    loaded.own_tissues["vessel"] = [vessel = loaded.vessel](const Volume& scan,
                                                            const TaskArena& own) {
        return make_vessel(scan, vessel->wall, vessel->settings, own);
    };
    return loaded;
}

/// Hash of the geometry that affects a catheter, because another wall or catheter would replay a
/// session differently.
std::uint64_t hash_of(const MadeVessel& vessel, std::uint64_t scan) {
    Hash64 hash;
    hash.add_word(scan);
    hash.add(std::span<const Vec3d>(vessel.wall.mesh.nodes_mm));
    hash.add(std::span<const std::array<std::int32_t, 4>>(vessel.wall.mesh.cells));
    const CatheterSettings& s = vessel.settings;
    const CatheterShape& c = s.catheter;
    const WallTissue& w = s.wall;
    for (const double number : {c.length_mm,        c.segment_mm,        c.radius_mm,
                                c.bend_n_mm2,       c.twist_n_mm2,       c.tip_mm,
                                c.tip_bend_n_mm2,   c.mass_g_mm,         c.damping_per_s,
                                c.friction,         w.young_modulus_pa,  w.poisson_ratio,
                                w.density_g_mm3,    w.support_pa_per_mm, w.damping_per_s,
                                s.box_mm,           s.reach_mm,          s.time_step_s,
                                double(s.local),    double(s.sub_steps), double(s.iterations),
                                s.entry.inserted_mm})
        hash.add_word(std::bit_cast<std::uint64_t>(number));
    // Only settings that differ from the defaults: the hashes of other scenes stay.
    const auto add_changed = [&](std::uint64_t key, double number, double usual) {
        if (number == usual) return;
        hash.add_word(key);
        hash.add_word(std::bit_cast<std::uint64_t>(number));
    };
    if (w.model == WallModel::Distances) {
        hash.add_word(2);
        for (const double share : {w.stretch_stiffness, w.bend_stiffness, w.volume_stiffness})
            hash.add_word(std::bit_cast<std::uint64_t>(share));
    }
    for (int a = 0; a < 3; ++a) add_changed(3 + std::uint64_t(a), w.gravity_mm_s2[a], 0);
    add_changed(8, double(w.iterations), 1);
    add_changed(9, double(w.alternates), 0);
    if (w.model == WallModel::Rigid) hash.add_word(11);
    if (vessel.has_own_ghost) {
        hash.add_word(10);
        hash.add(std::span<const Vec3d>(vessel.wall.ghost.nodes_mm));
        hash.add(std::span<const std::array<std::int32_t, 3>>(vessel.wall.ghost.cells));
    }
    for (const Vec3d v : {s.entry.position_mm, s.entry.direction})
        for (int a = 0; a < 3; ++a) hash.add_word(std::bit_cast<std::uint64_t>(v[a]));
    return hash.value();
}

/// Sets the defaults that follow from the scan's values.
void suit(LoadedScan& loaded, const ReadNotes& notes) {
    const ValueDefaults& values = loaded.info.values = value_defaults(loaded.volume, notes);
    loaded.volume.background = float(values.background);
    loaded.iso_hu = values.iso;
    loaded.polarity = values.lumen_is_bright ? Polarity::Falling : Polarity::Rising;
    suit_materials(values, loaded.settings);
}

ReadOptions reading_of(const SceneSource& source, const std::function<bool()>& give_up) {
    return {.series_uid = source.series,
            .may_map = false,
            .progress = {},
            .give_up = give_up,
            .frame = source.frame,
            .straighten = source.straighten,
            .spacing_mm = source.spacing_mm};
}

/// Organs have a mesh or labels of their own; their surroundings have neither.
bool is_surroundings(const Organ& organ) {
    return organ.settings.mesh.empty() && organ.settings.labels.empty();
}

/// View of all organs, from the front. In a scan the tip is in their middle, so that the view from
/// outside is cut open there.
Endoscope in_front_of(const MadeOrgans& made) {
    Vec3d low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    for (const Organ& organ : made.organs) {
        if (is_surroundings(organ)) continue;
        for (const Vec3d& p : organ.mesh.nodes_mm)
            for (int a = 0; a < 3; ++a) {
                low[a] = std::min(low[a], p[a]);
                high[a] = std::max(high[a], p[a]);
            }
    }
    const Vec3d middle = 0.5 * (low + high), half = 0.5 * (high - low);
    Endoscope view{.look = {0, 1, 0}, .up = {0, 0, 1}, .fog_distance_mm = 0};
    const double wide = std::tan(view.field_of_view_deg * std::numbers::pi / 360);
    view.eye_mm = middle;
    if (made.file.scan.empty())
        view.eye_mm = middle - (half.y + 1.05 * std::max(half.x, half.z) / wide) * view.look;
    return view;
}

/// Radius of tools that hold several nodes of each organ; surroundings may be coarser.
double tool_mm_for(const MadeOrgans& made) {
    double edge_mm = 0;
    for (const Organ& organ : made.organs)
        if (!is_surroundings(organ)) edge_mm = std::max(edge_mm, mean_edge_mm(organ.mesh));
    return kToolEdges * edge_mm;
}

/// @returns one line that names the file
Result<LoadedScan> load_organs(const SceneSource& source, const TaskArena& arena,
                               const std::function<bool()>& give_up) {
    auto file = source.bodies
                    ? organ_file_of_labels(source.file, source.labels, *source.bodies,
                                           source.label_names, reading_of(source, give_up))
                : is_organ_file(source.file) ? read_organ_file(source.file)
                                             : Result(organ_file_of_mesh(source.file));
    if (!file.ok()) return file.error();
    file->reading = reading_of(source, give_up);
    if (!source.units.empty()) file->units = source.units;
    auto made = make_organs(*file, arena);
    if (!made.ok()) return made.error();
    made->file.reading.give_up = {};  // it belongs to the caller
    LoadedScan loaded;
    loaded.volume = std::exchange(made->scan, {});
    loaded.hash = made->hash;
    if (!file->scan.empty()) suit(loaded, made->notes);
    if (loaded.info.values.kind == ValueKind::Hounsfield) {
        loaded.info.values.window = kOrganWindow_hu;
        loaded.info.values.level = kOrganLevel_hu;
    }
    loaded.info.start = in_front_of(*made);
    loaded.info.tool_mm = tool_mm_for(*made);
    loaded.info.starts_outside = true;
    loaded.info.name = std::filesystem::path(source.file).filename().string();
    auto bodies = map_bodies(*made, loaded.volume, arena);
    if (!bodies.ok()) return bodies.error();
    loaded.bodies = std::move(*bodies);
    loaded.own_tissues["own"] = [organs = std::make_shared<const MadeOrgans>(std::move(*made))](
                                    const Volume& scan,
                                    const TaskArena& own) -> Result<std::unique_ptr<Tissue>> {
        auto tissue = make_tissue(*organs, scan, own);
        if (!tissue.ok()) return tissue.error();
        return std::unique_ptr<Tissue>(std::move(*tissue));
    };
    return loaded;
}

/// Reads the tissues' settings and label materials. Empty names leave the settings as they are.
Status load_materials(const SceneSource& source, const TaskArena& arena, LoadedScan& loaded) {
    if (source.config.empty()) return Ok{};
    auto settings = read_chainmail_settings(source.config, loaded.info.values);
    if (!settings.ok()) return settings.error();
    loaded.settings = std::move(*settings);
    auto elastic = read_elastic_settings(source.config, loaded.info.values);
    if (!elastic.ok()) return elastic.error();
    loaded.elastic = std::move(*elastic);
    Hash64 hash;
    hash.add_word(loaded.hash);
    const auto text = read_small_file(source.config, kMaxSmallFileBytes, "a settings file");
    if (!text.ok()) return text.error();
    hash.add(std::span<const char>(*text));
    const auto tables = parse_toml(*text);
    loaded.has_chainmail_settings =
        tables.ok() && std::ranges::any_of(*tables, [](const TomlTable& table) {
            return table.name != "elastic";  // the readers have refused unknown tables
        });
    if (!source.labels.empty() && !loaded.settings.label_materials.empty()) {
        auto labels = read_labels(source.labels);
        if (!labels.ok()) return about("labels", labels.error().code, labels.error().message);
        hash.add_word(hash_volume(*labels));
        labels = labels_on(*labels, loaded.volume.grid, arena);
        if (!labels.ok()) return labels.error();
        loaded.settings.labels = std::make_shared<const Volume>(std::move(*labels));
    }
    if (!source.directions.empty()) {
        auto directions = read_vector_field(source.directions);
        if (!directions.ok())
            return about("directions", directions.error().code, directions.error().message);
        hash.add(std::span<const Vec3f>(directions->vectors_mm));
        loaded.settings.directions = std::make_shared<const VectorField>(std::move(*directions));
    }
    loaded.hash = hash.value();
    return Ok{};
}

/// Hash of all numbers that affect the motion.
std::uint64_t hash_of(const SpringParts& parts, std::uint64_t scan) {
    Hash64 hash;
    hash.add_word(scan);
    const auto add = [&](double number) { hash.add_word(std::bit_cast<std::uint64_t>(number)); };
    for (const SpringNode& node : parts.nodes) {
        for (int a = 0; a < 3; ++a) add(node.rest[a]);
        add(node.mass);
        add(node.damping);
        hash.add_word(node.fixed);
    }
    for (const SpringLink& link : parts.links) {
        hash.add_word(std::uint64_t(link.a) << 32 | std::uint64_t(link.b));
        add(link.stiffness);
        add(link.damping);
        add(link.rest_length);
    }
    for (const SpringCell& cell : parts.cells) {
        for (int n = 0; n < cell.node_count; ++n)
            hash.add_word(std::uint64_t(cell.nodes[std::size_t(n)]));
        add(cell.bulk);
    }
    return hash.value();
}

/// Reads a network that moves the scan instead of its own model.
Status load_network(const SceneSource& source, LoadedScan& loaded) {
    if (source.network.empty()) return Ok{};
    if (loaded.vessel)
        return about("network", ErrorCode::InvalidArgument,
                     "expected a scan or an organ, found the scene of a vessel");
    auto network = read_network(source.network);
    if (!network.ok()) return about("network", network.error().code, network.error().message);
    loaded.hash = hash_of(network->parts, loaded.hash);
    loaded.own_tissues["own"] =
        [parts = std::make_shared<const SpringParts>(std::move(network->parts))](
            const Volume& volume, const TaskArena& arena) {
            return make_network(volume, *parts, {}, arena);
        };
    return Ok{};
}

}  // namespace

bool is_vessel_scene(const std::filesystem::path& file) {
    return file.extension() == ".toml" && !is_organ_file(file);
}

Result<LoadedScan> load_scan(const SceneSource& source, const TaskArena& arena,
                             const std::function<bool()>& give_up) {
    LoadedScan loaded;
    const bool is_organ =
        !source.bodies && (is_organ_file(source.file) || is_mesh_file(source.file));
    if (!source.units.empty() && !is_organ)
        return expected_error("units", "a mesh or a scene of organs, whose unit it is",
                              source.file.empty() ? "a phantom" : source.file);
    if (is_vessel_scene(source.file)) {
        auto vessel = load_vessel(source, arena);
        if (!vessel.ok()) return vessel.error();
        loaded = std::move(*vessel);
    } else if (source.bodies || is_organ) {
        auto organs = load_organs(source, arena, give_up);
        if (!organs.ok()) return organs.error();
        loaded = std::move(*organs);
    } else if (source.file.empty()) {
        auto phantom = make_phantom({.name = source.phantom, .size = source.phantom_size}, arena);
        if (!phantom.ok()) return phantom.error();
        loaded.volume = std::move(phantom->volume);
        loaded.info.landmarks = std::move(phantom->landmarks);
        loaded.info.name = source.phantom + " phantom";
    } else {
        ReadNotes notes;
        auto volume = read_volume(source.file, reading_of(source, give_up), &notes);
        if (!volume.ok()) return volume.error();
        const Vec3i read = volume->grid.size;
        if (std::min({read.x, read.y, read.z}) == 1) volume = with_doubled_slices(*volume);
        if (!volume.ok()) return volume.error();
        loaded.volume = std::move(*volume);
        suit(loaded, notes);
        loaded.info.name = std::filesystem::path(source.file).filename().string();
    }
    const Vec3i size = loaded.volume.grid.size;
    if (std::max({size.x, size.y, size.z}) > 65535)
        return Error{ErrorCode::LimitExceeded,
                     loaded.info.name + ": expected up to 65535 voxels along an axis, found " +
                         std::to_string(std::max({size.x, size.y, size.z}))};
    loaded.info.grid = loaded.volume.grid;
    std::visit([&](const auto& values) { find_range(values, loaded.info); }, loaded.volume.voxels);
    // A scan's key values may recommend a view, as our phantoms' do.
    const KeyValues& keys = loaded.volume.key_values;
    loaded.iso_hu = std::clamp(number_of(keys, "iso_hu").value_or(loaded.iso_hu), -kMaxThreshold,
                               kMaxThreshold);
    if (value_of(keys, "polarity") == "falling") loaded.polarity = Polarity::Falling;
    suit_elastic(loaded.info.values, loaded.elastic);
    if (const auto bone = number_of(keys, "bone_threshold_hu"))
        loaded.settings.bone_threshold_hu = loaded.elastic.held_above_hu =
            std::clamp(*bone, -32768.0, 32768.0);
    if (!loaded.info.landmarks.empty())
        loaded.info.start = Endoscope{.eye_mm = loaded.info.landmarks[0].eye_mm,
                                      .look = loaded.info.landmarks[0].look};
    else if (!loaded.info.start)
        loaded.info.start = find_endoscope(loaded.volume, loaded.iso_hu, loaded.polarity, arena);
    if (!loaded.info.start && loaded.info.values.kind != ValueKind::Hounsfield)
        loaded.info.start = view_of_whole(loaded.volume);
    loaded.hash ^= hash_volume(loaded.volume);
    if (loaded.vessel) loaded.hash = hash_of(*loaded.vessel, loaded.hash);
    if (const Status status = load_materials(source, arena, loaded); !status.ok())
        return status.error();
    if (const Status status = load_network(source, loaded); !status.ok()) return status.error();
    loaded.settings.history_max_steps = kHistorySteps;
    if (source.own_tissue) loaded.own_tissues["own"] = *source.own_tissue;
    return loaded;
}

}  // namespace pliant::serve
