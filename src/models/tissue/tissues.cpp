// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/tissues.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/errors.h"
#include "base/text.h"
#include "base/units.h"
#include "material/labels.h"
#include "tissue/body_tissue.h"
#include "tissue/chainmail_tissue.h"
#include "tissue/elastic_tissue.h"
#include "tissue/network_tissue.h"
#include "tissue/spring_tissue.h"

namespace pliant {
namespace {

using S = SpringDeformationSettings;

constexpr Setting<S> kSpringRows[] = {
    setting<&S::cell_mm>({.name = "cell_mm",
                          .unit = "mm",
                          .range = {0, 1000},
                          .above_low = true,
                          .text = "edge of a control cell, rounded to whole voxels"}),
    setting<&S::young_modulus_pa>({.name = "young_modulus_pa",
                                   .unit = "Pa",
                                   .range = {1, 1e9},
                                   .text = "Young's modulus of tissue; air has a hundredth of it"}),
    setting<&S::poisson_ratio>({.name = "poisson_ratio",
                                .range = {0.25, 0.499},
                                .text = "Poisson's ratio of tissue; air has 0.25, that of links"}),
    setting<&S::air_threshold_hu>(
        {.name = "air_threshold_hu", .unit = "HU", .text = "smaller values are air"}),
    setting<&S::fixed_hu>({.name = "fixed_hu",
                           .unit = "HU",
                           .text = "nodes with a larger mean value around them don't move"}),
    setting<&S::fixed_share>({.name = "fixed_share",
                              .range = {0, 1},
                              .text = "nor do those of cells with a larger share of such voxels"}),
    setting<&S::depth>({.name = "depth",
                        .unit = "layers",
                        .range = {0, 1e6},
                        .text = "layers of nodes that forces reach beyond a tool"}),
    setting<&S::damping_s>({.name = "damping_s",
                            .unit = "s",
                            .range = {1e-4, 1e4},
                            .text = "time in which free motion dies away to 1/e"}),
};

constexpr TissueTraits kModels[] = {
    {.model = "chainmail", .slides = true, .cuts = true, .carves = true, .has_energy = true},
    {.model = "elastic", .slides = true, .cuts = true, .carves = true, .moves_by_itself = true},
    {.model = "springs", .cuts = true, .moves_by_itself = true},
    {.model = "body", .slides = true, .cuts = true, .moves_by_itself = true},
    {.model = "vessel", .takes_pushes = false, .moves_by_itself = true},
    {.model = "rigid"},
};

class RigidTissue final : public NodeTissue {
  public:
    RigidTissue(const Volume& scan, const TaskArena& arena, Deformation rest)
        : m_scan(scan), m_arena(arena), m_rest(std::move(rest)) {}
    TissueTraits traits() const noexcept override { return {.model = "rigid"}; }
    Result<PushReport> push(std::uint32_t, const Push& push) noexcept override {
        return attempt([&]() -> Result<PushReport> {
            if (!is_finite(push.point_mm) || !is_finite(push.push_mm) ||
                !(push.sphere_radius_mm >= 0))
                return expected_error("push", "finite numbers", text_of(push.push_mm));
            return PushReport{.limited_by = LimitedBy::Bone, .message = "the tissue is rigid"};
        });
    }
    void release(std::uint32_t) noexcept override {}
    bool is_touched_by(std::uint32_t) const noexcept override { return false; }
    bool is_touched() const noexcept override { return false; }
    Result<Sweep> sweep() noexcept override { return Sweep{}; }
    Status reset() noexcept override { return Ok{}; }
    void state(std::vector<double>& numbers) const override { numbers.clear(); }
    Status set_state(std::span<const double> numbers) noexcept override {
        if (numbers.empty()) return Ok{};
        return attempt([]() -> Status { return invalid("expected no numbers"); });
    }
    std::uint64_t file_kind() const noexcept override { return 0x34'72'73'6c'70'00'00'0a; }
    const Volume& volume() const override { return m_scan; }
    const Deformation& deformation() const override { return m_rest; }
    const TaskArena& arena() const override { return m_arena; }

  private:
    const Volume& m_scan;
    const TaskArena& m_arena;
    Deformation m_rest;
};

using B = BodySettings;

constexpr Setting<B> kBodyRows[] = {
    setting<&B::young_modulus_pa>(
        {.name = "young_modulus_pa", .unit = "Pa", .range = {1, 1e9}, .text = "Young's modulus"}),
    setting<&B::poisson_ratio>({.name = "poisson_ratio",
                                .range = {0, 0.499},
                                .above_low = true,
                                .text = "Poisson's ratio"}),
    setting<&B::ogden_alpha>({.name = "ogden_alpha",
                              .range = {-40, 40},
                              .text = "exponent of the stretches in Ogden's law, −40 to −1 "
                                      "(stiffer in compression) or 2 to 40; 2: neo-Hookean"}),
    setting<&B::density_kg_m3>(
        {.name = "density_kg_m3", .unit = "kg/m³", .range = {1, 1e5}, .text = "density"}),
    setting<&B::damping_per_s>({.name = "damping_per_s",
                                .unit = "1/s",
                                .range = {0, 1e3},
                                .text = "damping of velocities"}),
    setting<&B::fixed_hu>({.name = "fixed_hu",
                           .unit = "HU",
                           .text = "nodes at a larger value of the scan don't move"}),
    setting<&B::time_step_s>({.name = "time_step_s",
                              .unit = "s",
                              .range = {1e-5, 0.1},
                              .text = "simulated time of a step"}),
    setting<&B::sub_steps>(
        {.name = "sub_steps", .range = {1, 1000}, .text = "sub-steps of a time step, at least"}),
    setting<&B::reach_mm>({.name = "reach_mm",
                           .unit = "mm",
                           .range = {0, 1000},
                           .above_low = true,
                           .text = "distance from the body at which the scan rests"}),
};

using N = NetworkSettings;

constexpr Setting<N> kNetworkRows[] = {
    setting<&N::time_step_s>({.name = "time_step_s",
                              .unit = "s",
                              .range = {1e-5, 0.1},
                              .text = "simulated time of a step"}),
    setting<&N::solve_tolerance>({.name = "solve_tolerance",
                                  .range = {0, 1},
                                  .above_low = true,
                                  .below_high = true,
                                  .text = "relative residual of a step's equations"}),
    setting<&N::reach_mm>({.name = "reach_mm",
                           .unit = "mm",
                           .range = {0, 1000},
                           .above_low = true,
                           .text = "distance from the network at which the scan rests"}),
};

/// Value of the nearest voxel; the background outside of the scan.
double value_at(const Volume& scan, Vec3d position_mm) {
    const Vec3d ijk = voxel_from_world(scan.grid, position_mm);
    Vec3i nearest;
    for (int a = 0; a < 3; ++a) {
        if (!(ijk[a] > -0.5 && ijk[a] < scan.grid.size[a] - 0.5)) return double(scan.background);
        nearest[a] = int(std::lround(ijk[a]));
    }
    return double(scan.at(nearest));
}

std::vector<std::array<std::int32_t, 4>> cells_of(const PbdParts& parts) {
    std::vector<std::array<std::int32_t, 4>> cells;
    for (const PbdSolid& solid : parts.solids) cells.push_back(solid.nodes);
    if (cells.empty())
        for (const PbdVolume& volume : parts.volumes) cells.push_back(volume.nodes);
    return cells;
}

}  // namespace

SettingRows<SpringDeformationSettings> spring_rows() noexcept {
    return kSpringRows;
}

SettingRows<BodySettings> body_rows() noexcept {
    return kBodyRows;
}

SettingRows<NetworkSettings> network_rows() noexcept {
    return kNetworkRows;
}

std::span<const TissueTraits> tissue_models() noexcept {
    return kModels;
}

Result<std::unique_ptr<Tissue>> make_chainmail(const Volume& scan,
                                               const ChainMailSettings& settings,
                                               const TaskArena& arena,
                                               RestingTool resting) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<Tissue>> {
        auto model = ChainMail::create(scan, settings, arena);
        if (!model) return model.error();
        return std::unique_ptr<Tissue>(new ChainMailTissue(std::move(*model), resting));
    });
}

Result<std::unique_ptr<Tissue>> make_springs(const Volume& scan,
                                             const SpringDeformationSettings& settings,
                                             const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<Tissue>> {
        auto made = SpringScanTissue::create(scan, settings, arena);
        if (!made) return made.error();
        return std::unique_ptr<Tissue>(std::move(*made));
    });
}

Status take_materials(const ChainMailSettings& materials, ElasticScanSettings& settings) noexcept {
    return attempt([&]() -> Status {
        settings.label_materials = materials.label_materials;
        settings.labels = materials.labels;
        return Ok{};
    });
}

Result<std::unique_ptr<Tissue>> make_elastic(const Volume& scan,
                                             const ElasticScanSettings& settings,
                                             const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<Tissue>> {
        if (const Status s = check_volume(scan); !s.ok()) return s.error();
        if (const Status s = check_elastic_scan(settings); !s.ok()) return s.error();
        ElasticScanSettings used = settings;
        if (used.moduli_kpa.empty()) {
            ElasticScanSettings of_ct;
            suit_elastic({}, of_ct);
            used.moduli_kpa = std::move(of_ct.moduli_kpa);
        }
        if (std::min({scan.grid.size.x, scan.grid.size.y, scan.grid.size.z}) < 2)
            return invalid("elastic: expected 2 voxels or more along each axis");
        ChainMailSettings labelled;
        labelled.label_materials = used.label_materials;
        for (LabelMaterial& material : labelled.label_materials) material.along_direction = false;
        labelled.labels = used.labels;
        if (const Status s = check_labels(labelled, scan.grid); !s.ok()) return s.error();
        return std::unique_ptr<Tissue>(new ElasticTissue(scan, used, arena));
    });
}

std::string_view model_of(const ScanTissueSettings& settings) noexcept {
    return std::holds_alternative<ElasticScanSettings>(settings) ? "elastic" : "chainmail";
}

Result<std::unique_ptr<Tissue>> make_scan_tissue(const Volume& scan,
                                                 const ScanTissueSettings& settings,
                                                 const TaskArena& arena) noexcept {
    if (const auto* const elastic = std::get_if<ElasticScanSettings>(&settings))
        return make_elastic(scan, *elastic, arena);
    return make_chainmail(scan, *std::get_if<ChainMailSettings>(&settings), arena);
}

Result<std::unique_ptr<Tissue>> make_body(const Volume& scan, PbdBody body,
                                          const BodySettings& settings,
                                          const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<Tissue>> {
        if (const Status s = check(settings, body_rows()); !s.ok()) return s.error();
        BodyPlan plan{.mesh = {body.parts().positions, cells_of(body.parts())},
                      .steps = body.settings().sub_steps,
                      .reach_mm = settings.reach_mm};
        if (plan.steps > 1) {  // contact follows each sub-step
            PbdSettings one = body.settings();
            one.time_step /= one.sub_steps;
            one.sub_steps = 1;
            auto stepped = PbdBody::create(body.parts(), one);
            if (!stepped) return stepped.error();
            body = std::move(*stepped);
        }
        auto made = BodyTissue::create(scan, std::move(body), std::move(plan), arena);
        if (!made) return made.error();
        return std::unique_ptr<Tissue>(std::move(*made));
    });
}

Result<std::unique_ptr<Tissue>> make_body(const Volume& scan, const TetMesh& mesh,
                                          const BodySettings& settings,
                                          const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<Tissue>> {
        if (const Status s = check_volume(scan); !s.ok()) return s.error();
        if (const Status s = check(settings, body_rows()); !s.ok()) return s.error();
        auto parts = pbd_of_mesh(mesh, {.density = kGramsPerMm3 * settings.density_kg_m3,
                                        .edges = false,
                                        .volumes = false,
                                        .solids = true,
                                        .young_modulus = settings.young_modulus_pa,
                                        .poisson_ratio = settings.poisson_ratio,
                                        .ogden_alpha = settings.ogden_alpha});
        if (!parts) return parts.error();
        for (std::size_t n = 0; n < parts->positions.size(); ++n)
            if (value_at(scan, parts->positions[n]) > settings.fixed_hu)
                parts->inverse_masses[n] = 0;
        const auto sub_steps = body_steps(*parts, settings.time_step_s, settings.sub_steps);
        if (!sub_steps) return sub_steps.error();
        auto body = PbdBody::create(std::move(*parts), {.time_step = settings.time_step_s,
                                                        .sub_steps = *sub_steps,
                                                        .damping = settings.damping_per_s,
                                                        .warm_starts = true});
        if (!body) return body.error();
        return make_body(scan, std::move(*body), settings, arena);
    });
}

Result<std::unique_ptr<Tissue>> make_network(const Volume& scan, SpringParts parts,
                                             const NetworkSettings& settings,
                                             const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<Tissue>> {
        auto made = NetworkTissue::create(scan, std::move(parts), settings, arena);
        if (!made) return made.error();
        return std::unique_ptr<Tissue>(std::move(*made));
    });
}

Result<std::unique_ptr<Tissue>> make_rigid(const Volume& scan, const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<Tissue>> {
        auto rest = Deformation::create(scan.grid);
        if (!rest) return rest.error();
        return std::unique_ptr<Tissue>(new RigidTissue(scan, arena, std::move(*rest)));
    });
}

}  // namespace pliant
