// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "deform_models.h"

#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <pliant/models/network_file.h>
#include <pliant/models/scene_files.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>
#include <variant>

#include "scan_defaults.h"
#include "setting_options.h"

namespace pliant::app {
namespace {

using Models = std::vector<std::string_view>;

Error other_model(const std::string& option, const Models& models, const DeformOptions& o) {
    std::string expected;
    for (const std::string_view model : models)
        expected.append(expected.empty() ? "" : " or ").append(model);
    // Without --model another option is missing.
    if (o.model == DeformOptions{}.model) expected += " too";
    return {ErrorCode::InvalidArgument,
            option + ": expected --model " + expected + ", found " + o.model};
}

struct GivenOption {
    std::string name;
    bool is_given;
    Models models;  ///< that take it
};

std::vector<GivenOption> options_of_models(const DeformOptions& o) {
    std::vector<GivenOption> options;
    for (const NamedValue& setting : o.settings) {
        Models models;
        if (find_setting(setting.name, spring_rows()) || find_setting(setting.name, network_rows()))
            models.push_back("springs");
        if (find_setting(setting.name, body_rows())) models.push_back("body");
        if (find_setting(setting.name, elastic_scan_rows())) models.push_back("elastic");
        options.push_back({option_of(setting.name), true, std::move(models)});
    }
    const Models chainmail = {"chainmail"};
    Models labelled = {"chainmail"};  // --network has its own stiffness
    if (o.network.empty()) labelled.push_back("springs");
    labelled.push_back("elastic");
    const Models stateful = {"chainmail", "springs", "body", "elastic"};
    for (GivenOption& option : std::vector<GivenOption>{
             {"--region", o.region_mm.has_value(), {"springs"}},
             {"--steps", o.steps.has_value(), {"springs", "body", "elastic"}},
             {"--depth", o.depth_within_mm.has_value(), {"springs"}},
             {"--network", !o.network.empty(), {"springs"}},
             {"--mesh", !o.mesh.empty(), {"body"}},
             {"--config", !o.config.empty(), labelled},
             {"--labels", !o.labels.empty() && o.labels_out.empty(), labelled},
             {"--directions", !o.directions.empty(), chainmail},
             {"--relax", o.relax_ms.has_value(), chainmail},
             {"--relax-sweeps", o.relax_sweeps.has_value(), chainmail},
             {"--solver", !o.solver.empty(), chainmail},
             {"--load-state", !o.load_state.empty(), stateful},
             {"--save-state", !o.save_state.empty(), stateful},
         })
        options.push_back(std::move(option));
    return options;
}

/// Models that take a kind of action.
Models models_with(bool TissueTraits::*contact) {
    Models models;
    for (const TissueTraits& traits : tissue_models())
        if (traits.*contact) models.push_back(traits.model);
    return models;
}

/// Refuses options of a lattice beside a network, and those of a network without one.
Status check_network(const DeformOptions& o) {
    if (o.model != "springs") return Ok{};
    const bool cuts = std::any_of(o.actions.begin(), o.actions.end(), [](const auto& action) {
        return std::holds_alternative<CutSurface>(action);
    });
    if (cuts && !o.network.empty())
        return Error{ErrorCode::InvalidArgument,
                     "--cut: expected springs of the scan, found --network, which can't be cut"};
    std::string option = o.network.empty()   ? ""
                         : o.region_mm       ? "--region"
                         : o.depth_within_mm ? "--depth"
                                             : "";
    for (const NamedValue& setting : o.settings)
        if (o.network.empty() ? !find_setting(setting.name, spring_rows())
                              : !find_setting(setting.name, network_rows()))
            option = option_of(setting.name);
    if (option.empty()) return Ok{};
    return Error{ErrorCode::InvalidArgument,
                 option + (o.network.empty()
                               ? ": expected --network too, found none"
                               : ": expected none beside --network, whose file has its nodes and "
                                 "stiffness, found one")};
}

// ChainMail.

/// Settings of the command line for a scan with these values. Limits are rounded unless the file
/// says otherwise or a solver of the box is chosen.
Result<ChainMailSettings> settings_for(const DeformOptions& o, const ValueDefaults& values,
                                       std::vector<std::string>* notes = nullptr) {
    ChainMailSettings settings;
    settings.limits = o.solver.empty() ? LinkLimits::Rounded : LinkLimits::Box;
    suit_materials(values, settings);
    if (!o.config.empty()) {
        auto read = read_chainmail_settings(o.config, values, notes, settings.limits);
        if (!read.ok()) return read.error();
        settings = std::move(*read);
    }
    if (!o.solver.empty() && settings.limits == LinkLimits::Rounded)
        return Error{ErrorCode::InvalidArgument,
                     "--solver: expected [material] limits = \"box\" in --config, found "
                     "\"rounded\", which has one solver"};
    return settings;
}

Result<ChainMailSettings> chainmail_settings(const DeformOptions& o,
                                             std::vector<std::string>& notes) {
    auto read = settings_for(o, {}, &notes);
    if (!read.ok()) return read.error();
    ChainMailSettings settings = *read;
    settings.solver = o.solver == "heap" ? ChainMailSolver::Heap : ChainMailSolver::Sweep;
    if (!o.labels.empty() && settings.label_materials.empty() && o.labels_out.empty())
        return Error{ErrorCode::InvalidArgument,
                     "--labels: expected [[label]] tables in --config, or --labels-out, found "
                     "neither"};
    if (!o.labels.empty() && !settings.label_materials.empty()) {
        auto labels = read_labels(o.labels);
        if (labels.ok()) labels = with_doubled_slices(*labels);  // as the scan
        if (!labels.ok()) return Error{labels.error().code, "--labels: " + labels.error().message};
        settings.labels = std::make_shared<const Volume>(std::move(*labels));
    }
    if (!o.directions.empty()) {
        auto directions = read_vector_field(o.directions);
        if (!directions.ok())
            return Error{directions.error().code, "--directions: " + directions.error().message};
        settings.directions = std::make_shared<const VectorField>(std::move(*directions));
    }
    return settings;
}

/// Puts the labels of label materials on the scan's grid.
Status place_labels(const Volume& scan, const TaskArena& arena, ChainMailSettings& settings) {
    if (!settings.labels) return Ok{};
    auto labels = labels_on(*settings.labels, scan.grid, arena);
    if (!labels.ok()) return labels.error();
    settings.labels = std::make_shared<const Volume>(std::move(*labels));
    return Ok{};
}

Result<MakeScanTissue> prepare_chainmail(const DeformOptions& o, std::vector<std::string>& notes) {
    auto settings = chainmail_settings(o, notes);
    if (!settings.ok()) return settings.error();
    if (std::ranges::any_of(settings->label_materials,
                            [](const LabelMaterial& label) { return label.elastic.has_value(); }))
        notes.push_back(
            "[[label]] elastic has no effect on ChainMail; expected --model elastic or springs");
    return MakeScanTissue([&o, read = std::move(*settings)](
                              const Volume& scan, const ValueDefaults& values,
                              const TaskArena& arena) -> Result<std::unique_ptr<Tissue>> {
        ChainMailSettings suited = read;
        if (values.kind != ValueKind::Hounsfield) {
            auto others = settings_for(o, values);
            if (!others.ok()) return others.error();
            suited = std::move(*others);
            suited.solver = read.solver;
            suited.labels = read.labels;
            suited.directions = read.directions;
        }
        if (const Status s = place_labels(scan, arena, suited); !s) return s.error();
        return make_chainmail(scan, suited, arena, RestingTool::HoldsElements);
    });
}

// Springs.

/// Box of voxels between two corners.
Result<Box3i> region_of(const std::pair<Vec3d, Vec3d>& corners_mm, const Grid& grid) {
    const Vec3d one = voxel_from_world(grid, corners_mm.first);
    const Vec3d other = voxel_from_world(grid, corners_mm.second);
    Box3i box;
    for (int a = 0; a < 3; ++a) {
        const double low = std::max(0.0, std::ceil(std::min(one[a], other[a]) - 1e-6));
        const double high =
            std::min(grid.size[a] - 1.0, std::floor(std::max(one[a], other[a]) + 1e-6));
        if (!(low <= high))
            return Error{ErrorCode::InvalidArgument,
                         "--region: expected a box with voxels of the scan in it, found none "
                         "along axis " +
                             std::to_string(a)};
        box.begin[a] = int(low);
        box.end[a] = int(high) + 1;
    }
    return box;
}

Result<MakeScanTissue> prepare_network(const DeformOptions& o) {
    auto network = read_network(o.network);
    if (!network.ok()) return Error{network.error().code, "--network: " + network.error().message};
    return MakeScanTissue([&o, parts = std::move(network->parts)](
                              const Volume& scan, const ValueDefaults&,
                              const TaskArena& arena) -> Result<std::unique_ptr<Tissue>> {
        NetworkSettings settings;
        if (const Status s = apply(o.settings, network_rows(), settings); !s) return s.error();
        return make_network(scan, parts, settings, arena);
    });
}

Result<MakeScanTissue> prepare_springs(const DeformOptions& o, std::vector<std::string>& notes) {
    if (!o.network.empty()) return prepare_network(o);
    auto materials = chainmail_settings(o, notes);
    if (!materials.ok()) return materials.error();
    return MakeScanTissue([&o, materials = std::move(*materials)](
                              const Volume& scan, const ValueDefaults& values,
                              const TaskArena& arena) -> Result<std::unique_ptr<Tissue>> {
        SpringDeformationSettings settings;
        settings.air_threshold_hu = values.air_threshold;
        settings.fixed_hu = values.bone_threshold;
        ChainMailSettings labelled = materials;
        if (const Status s = place_labels(scan, arena, labelled); !s) return s.error();
        if (const Status s = take_materials(labelled, settings); !s) return s.error();
        if (const Status s = apply(o.settings, spring_rows(), settings); !s) return s.error();
        if (o.region_mm) {
            const auto region = region_of(*o.region_mm, scan.grid);
            if (!region.ok()) return region.error();
            settings.region = *region;
        }
        return make_springs(scan, settings, arena);
    });
}

// Bodies, and rigid tissue.

Result<MakeScanTissue> prepare_body(const DeformOptions& o, std::vector<std::string>&) {
    if (o.mesh.empty())
        return Error{ErrorCode::InvalidArgument,
                     "--mesh: expected a file of tetrahedra for --model body, found none"};
    auto mesh = read_tetrahedra(o.mesh, mm_of_unit(o.units));
    if (!mesh.ok()) return Error{mesh.error().code, "--mesh: " + mesh.error().message};
    return MakeScanTissue(
        [&o, mesh = std::move(*mesh)](const Volume& scan, const ValueDefaults& values,
                                      const TaskArena& arena) -> Result<std::unique_ptr<Tissue>> {
            BodySettings settings;
            settings.fixed_hu = values.bone_threshold;
            if (const Status s = apply(o.settings, body_rows(), settings); !s) return s.error();
            return make_body(scan, mesh, settings, arena);
        });
}

// The elastic scan.

Result<MakeScanTissue> prepare_elastic(const DeformOptions& o, std::vector<std::string>& notes) {
    // Mistakes in the settings are found before the scan is read.
    if (const auto settings = elastic_settings(o.config, o.settings, {}); !settings.ok())
        return settings.error();
    auto materials = chainmail_settings(o, notes);
    if (!materials.ok()) return materials.error();
    return MakeScanTissue([&o, materials = std::move(*materials)](
                              const Volume& scan, const ValueDefaults& values,
                              const TaskArena& arena) -> Result<std::unique_ptr<Tissue>> {
        auto settings = elastic_settings(o.config, o.settings, values);
        if (!settings.ok()) return settings.error();
        ChainMailSettings labelled = materials;
        if (const Status s = place_labels(scan, arena, labelled); !s) return s.error();
        if (const Status s = take_materials(labelled, *settings); !s) return s.error();
        return make_elastic(scan, *settings, arena);
    });
}

Result<MakeScanTissue> prepare_rigid(const DeformOptions&, std::vector<std::string>&) {
    return MakeScanTissue([](const Volume& scan, const ValueDefaults&, const TaskArena& arena) {
        return make_rigid(scan, arena);
    });
}

constexpr DeformModel kModels[] = {{"chainmail", prepare_chainmail},
                                   {"elastic", prepare_elastic},
                                   {"springs", prepare_springs},
                                   {"body", prepare_body, 5'000},
                                   {"rigid", prepare_rigid}};

}  // namespace

std::span<const DeformModel> deform_models() {
    return kModels;
}

const DeformModel& model_of(const DeformOptions& options) {
    return *std::find_if(std::begin(kModels), std::end(kModels),
                         [&](const DeformModel& m) { return m.name == options.model; });
}

const TissueTraits& traits_of(const DeformOptions& options) {
    const auto models = tissue_models();
    return *std::find_if(models.begin(), models.end(),
                         [&](const TissueTraits& t) { return t.model == options.model; });
}

Status check_model(const DeformOptions& o) {
    for (const GivenOption& option : options_of_models(o))
        if (option.is_given && std::count(option.models.begin(), option.models.end(), o.model) == 0)
            return other_model(option.name, option.models, o);
    if (const Status s = check_network(o); !s) return s;
    const TissueTraits& traits = traits_of(o);
    for (const DeformAction& action : o.actions) {
        const auto refused = [&](const char* option, bool TissueTraits::*contact) {
            return other_model(option, models_with(contact), o);
        };
        if (std::holds_alternative<SlideOption>(action) && !traits.slides && o.network.empty())
            return refused("--slide", &TissueTraits::slides);
        if (std::holds_alternative<CutSurface>(action) && !traits.cuts)
            return refused("--cut", &TissueTraits::cuts);
        if (std::holds_alternative<CarveTool>(action) && !traits.carves)
            return refused("--carve", &TissueTraits::carves);
    }
    return Ok{};
}

}  // namespace pliant::app
