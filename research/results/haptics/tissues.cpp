// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissues.h"

#include <pliant/models/pbd.h>
#include <pliant/models/springs.h>
#include <pliant/view/haptics.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace pliant::results {
namespace {

constexpr std::int32_t kSide = 6, kDeep = 6;
constexpr std::int32_t kFirst = kSide * kSide * (kDeep - 1) + (kSide + 1) * (kSide / 2 - 1);
constexpr std::array<std::int32_t, 4> kHeld{kFirst, kFirst + 1, kFirst + kSide, kFirst + kSide + 1};

class SpringBlock {
  public:
    SpringBlock() : m_tissue(make()) { value_of(m_tissue.hold(kHeld)); }

    SpringTissue& at(double depth_mm) {
        const double depth = std::clamp(depth_mm, 0.0, 6.0);  // cells invert at larger depths
        value_of(m_tissue.shift_held({0, 0, m_depth_mm - depth}));
        m_depth_mm = depth;
        value_of(m_tissue.find_equilibrium(1e-6));
        return m_tissue;
    }

  private:
    static SpringTissue make() {
        SpringParts parts = value_of(springs_of_lattice({.size = {kSide, kSide, kDeep},
                                                         .spacing = {4, 4, 4},
                                                         .stiffness = {15e3, 15e3, 15e3}}));
        for (SpringNode& node : parts.nodes) node.fixed = node.rest.z == 0;
        return value_of(
            SpringTissue::create(value_of(SpringNetwork::create(std::move(parts))), {.depth = 20}));
    }

    SpringTissue m_tissue;
    double m_depth_mm = 0;
};

/// Uses SI units; the tool is attached to a node of the top.
class PbdBlock {
  public:
    PbdBlock() : m_body(make(m_surface)) {}

    Vec3d force_n(Vec3d tool_mm, const TaskArena& arena) {
        const double z = std::clamp(1e-3 * tool_mm.z, -0.015, 0.0);
        value_of(m_body.move_attachment(0, m_surface + Vec3d{0, 0, z}));
        value_of(m_body.step(1, arena));
        const Vec3d force = -m_body.attachment_force(0);
        if (tool_mm.z < 0) m_learnt.add(tool_mm, force);
        return force;
    }
    Mat3d change_n_m() const { return m_learnt.change_n_m(); }

  private:
    static PbdBody make(Vec3d& surface) {
        const TetMesh mesh = five_tet_block({4, 4, 4}, 0.01);
        PbdParts parts = value_of(pbd_of_mesh(mesh, {.density = 1000,
                                                     .edges = false,
                                                     .volumes = false,
                                                     .solids = true,
                                                     .young_modulus = 1e4,
                                                     .poisson_ratio = 0.4}));
        const Vec3d middle{0.02, 0.02, 0.04};
        std::size_t top = 0;
        for (std::size_t n = 0; n < parts.positions.size(); ++n) {
            if (parts.positions[n].z < 1e-9) parts.inverse_masses[n] = 0;
            if (norm(parts.positions[n] - middle) < norm(parts.positions[top] - middle)) top = n;
        }
        surface = parts.positions[top];
        const auto node = std::int32_t(top);
        parts.attachments.push_back({.nodes = {node, node, node, node},
                                     .weights = {1, 0, 0, 0},
                                     .target = surface,
                                     .compliance = 1e-4});
        return value_of(PbdBody::create(std::move(parts), {.time_step = 0.033,
                                                           .sub_steps = 15,
                                                           .damping = 20,
                                                           .precision = PbdPrecision::Double}));
    }

    Vec3d m_surface{0, 0, 0};
    PbdBody m_body;
    LearntStiffness m_learnt{50, kDevice_n_m};
};

class WireInHand {
  public:
    WireInHand() : m_scene(wire_in_bend()), m_feel(hold(m_scene)) {}

    HapticModel at(Vec3d tool_mm, const TaskArena& arena) {
        if (!m_feel.holds()) m_feel.take_hold(tool_mm, 0, m_scene.quick_measures());
        const CatheterFeel::Motion motion = m_feel.follow(tool_mm, 0, m_scene.quick_measures());
        must(m_scene.command({.insert_mm_s = motion.insert_mm_s}));
        must(m_scene.step(8, arena));
        return value_of(checked_model(m_feel.model(tool_mm, m_scene.quick_measures()), 800));
    }

  private:
    static CatheterFeel hold(const CatheterScene& scene) {
        return value_of(CatheterFeel::create({.length_mm = scene.settings().catheter.length_mm}));
    }

    CatheterScene m_scene;
    CatheterFeel m_feel;
};

}  // namespace

Result<HapticModel> model_of_springs(SpringTissue& tissue, std::span<const std::int32_t> held,
                                     Vec3d surface_mm, Vec3d normal, Vec3d position_mm,
                                     LearntStiffness* last) {
    const auto reaction = tissue.reaction(held, ReactionLaw::Relaxed);
    if (!reaction.ok()) return reaction.error();
    Mat3d change{};
    for (int c = 0; c < 3; ++c)
        change.columns[c] = 1e-3 * reaction->stiffness.columns[c];  // N/m per µN/mm
    const Vec3d force_n = 1e-6 * reaction->force;
    if (last) {
        last->begin_with(change);
        last->add(position_mm, force_n);
        change = last->change_n_m();
    }
    return model_of_contact(surface_mm, normal, position_mm, force_n, change);
}

HapticModel wall(double stiffness_n_m) {
    HapticModel model;
    model.plane_count = 1;
    model.planes[0] = {{0, 0, 0}, {0, 0, 1}};
    for (int c = 0; c < 3; ++c) model.stiffness_n_m.columns[c][c] = stiffness_n_m;
    return model;
}

HapticModel force_of_wall(double stiffness_n_m, Vec3d tool_mm) {
    HapticModel model;
    if (tool_mm.z < 0) model.force_n = {0, 0, -1e-3 * stiffness_n_m * tool_mm.z};
    return model;
}

HapticTissue hardening() {
    return [](Vec3d x) {
        const double d = std::max(0.0, -1e-3 * x.z);
        Mat3d change{};
        change.columns[2].z = -(80 + 60'000 * d);
        return value_of(checked_model(
            model_of_contact({x.x, x.y, 0}, {0, 0, 1}, x, {0, 0, 80 * d + 30'000 * d * d}, change),
            kDevice_n_m));
    };
}

std::shared_ptr<const Volume> layers(double bone_depth_mm) {
    auto volume = std::make_shared<Volume>();
    volume->grid = {{48, 48, 48}, {0.8, 0.8, 0.8}, {-19, -19, -28}, kIdentity3};
    std::vector<std::int16_t> voxels;
    for (int k = 0; k < 48; ++k) {
        const double z = -28 + 0.8 * k;
        const double share = std::clamp(0.5 - z / 0.8, 0.0, 1.0);  // −300 HU at z = 0
        const bool is_bone = bone_depth_mm < 0;  // bone everywhere, including its surface
        const double value = is_bone              ? -1800 + share * 3000
                             : z < -bone_depth_mm ? 1200
                                                  : -640 + share * 680;
        voxels.insert(voxels.end(), 48 * 48, std::int16_t(std::lround(value)));
    }
    volume->voxels = std::move(voxels);
    return volume;
}

HapticTissue chainmail(std::shared_ptr<const Volume> volume, const TaskArena& arena) {
    const ChainMailFeelSettings settings;
    std::shared_ptr<ChainMailFeel> feel =
        value_of(ChainMailFeel::create(*volume, {}, settings, arena));
    const double radius = settings.tool_radius_mm;
    return [volume, feel, radius](Vec3d tool) {
        // In the middle of the phantom, like the other tissues.
        const Vec3d above{0, 0, radius};
        const Vec3d x = Vec3d{0, 0, tool.z} + above;
        HapticModel model = feel->model(x, {0, 0, std::max(x.z, radius)});
        for (int k = 0; k < model.plane_count; ++k)
            model.planes[k].point_mm = model.planes[k].point_mm - above;
        return value_of(checked_model(model, kDevice_n_m));
    };
}

HapticTissue springs() {
    auto block = std::make_shared<SpringBlock>();
    auto last = std::make_shared<LearntStiffness>(0, kDevice_n_m);
    return [block, last](Vec3d tool) {
        SpringTissue& tissue = block->at(-tool.z);
        return value_of(checked_model(
            value_of(model_of_springs(tissue, kHeld, {0, 0, 0}, {0, 0, 1}, tool, last.get())),
            kDevice_n_m));
    };
}

double static_force_of_springs_n(double depth_mm) {
    static SpringBlock block;
    return 1e-6 * value_of(block.at(depth_mm).reaction(kHeld, ReactionLaw::Held)).force.z;
}

HapticTissue pbd(const TaskArena& arena) {
    auto block = std::make_shared<PbdBlock>();
    return [block, &arena](Vec3d tool) {
        const Vec3d force = block->force_n(tool, arena);
        return value_of(checked_model(
            model_of_contact({0, 0, 0}, {0, 0, 1}, tool, force, block->change_n_m()), kDevice_n_m));
    };
}

CatheterScene wire_in_bend() {
    // Straight for 60 mm, a quarter circle, then straight.
    constexpr double kRadius_mm = 40, kInner_mm = 4;
    std::vector<CentrePoint> branch{{{0, 0, 0}, kInner_mm}};
    for (int n = 0; n <= 16; ++n) {
        const double angle = std::numbers::pi / 2 * n / 16;
        branch.push_back(
            {{kRadius_mm * (1 - std::cos(angle)), 0, 60 + kRadius_mm * std::sin(angle)},
             kInner_mm});
    }
    branch.push_back({{2 * kRadius_mm, 0, 60 + kRadius_mm}, kInner_mm});
    VesselWall wall =
        value_of(swept_tube(branch, {.thickness_mm = 1.5, .layers = 1, .sectors = 10}));
    CatheterSettings settings;
    settings.wall.support_pa_per_mm = 2000;
    settings.wall.density_g_mm3 = 0.05;
    settings.catheter.length_mm = 120;
    settings.catheter.bend_n_mm2 = 200;
    settings.catheter.tip_bend_n_mm2 = 100;
    settings.entry = {{0, 0, 45}, {0, 0, 1}, 27};
    settings.time_step_s = 0.004;
    return value_of(CatheterScene::create(std::move(wall), settings));
}

HapticTissue vessel(const TaskArena& arena) {
    return [wire = std::make_shared<WireInHand>(), &arena](Vec3d x) { return wire->at(x, arena); };
}

}  // namespace pliant::results
