// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/models/fit.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace pliant {
namespace {

constexpr double kMetres = 1e-3;  // m per mm
/// Larger references use conjugate gradients; the residual is relative to the load.
constexpr std::int64_t kMaxCholeskyNodes = 2000;
constexpr double kReferenceTolerance = 1e-11;
/// The closed form with volume energy needs more than 1/4 and less than 1/2. Poisson's ratio in the
/// plane across fibres may be anywhere in −1…1.
constexpr double kMinStartPoisson = 0.3, kMaxStartPoisson = 0.45;

Error bad_box(const std::string& text) {
    return {ErrorCode::InvalidArgument, "box: " + text};
}

int axis_of(BoxFace face) {
    return int(face) / 2;
}
int layer_of(const FitBox& box, BoxFace face) {
    return int(face) % 2 == 0 ? 0 : box.size[axis_of(face)] - 1;
}

std::vector<std::int32_t> nodes_of_face(const FitBox& box, const HexLattice& lattice) {
    std::vector<std::int32_t> nodes;
    const int axis = axis_of(box.held);
    for (int k = 0; k < box.size.z; ++k)
        for (int j = 0; j < box.size.y; ++j)
            for (int i = 0; i < box.size.x; ++i)
                if (const Vec3i p{i, j, k}; p[axis] == layer_of(box, box.held))
                    nodes.push_back(node_index(lattice, p));
    return nodes;
}

/// Selects the requested number of nodes around a position on the face.
Result<std::vector<std::int32_t>> loaded_nodes(const FitBox& box, const FitBoxLoad& load,
                                               const HexLattice& lattice) {
    const int axis = axis_of(load.face);
    const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
    int begin[2];
    for (const auto& [n, position, along] :
         {std::tuple(0, load.across, first), std::tuple(1, load.along, second)}) {
        if (!(position >= 0 && position <= 1))
            return bad_box("load " + load.name + ": expected a position from 0 to 1 on the face");
        if (load.nodes_across < 1 || load.nodes_across > box.size[along])
            return bad_box("load " + load.name + ": expected 1 to " +
                           std::to_string(box.size[along]) + " nodes across, found " +
                           std::to_string(load.nodes_across));
        const double middle = position * (box.size[along] - 1);
        begin[n] = std::clamp(int(std::lround(middle - 0.5 * (load.nodes_across - 1))), 0,
                              box.size[along] - load.nodes_across);
    }
    std::vector<std::int32_t> nodes;
    for (int b = 0; b < load.nodes_across; ++b)
        for (int a = 0; a < load.nodes_across; ++a) {
            Vec3i p{0, 0, 0};
            p[axis] = layer_of(box, load.face);
            p[first] = begin[0] + a;
            p[second] = begin[1] + b;
            nodes.push_back(node_index(lattice, p));
        }
    return nodes;
}

/// Axes along which a link extends, as bits.
int axes_of(const SpringParts& parts, const SpringLink& link) {
    const Vec3d r = parts.nodes[std::size_t(link.b)].rest - parts.nodes[std::size_t(link.a)].rest;
    int axes = 0;
    for (int a = 0; a < 3; ++a)
        if (std::abs(r[a]) > 1e-6 * norm(r)) axes |= 1 << a;
    return axes;
}

std::string group_name(FitBoxGroups groups, int axes) {
    const int count = (axes & 1) + (axes >> 1 & 1) + (axes >> 2);
    if (groups == FitBoxGroups::Uniform) return "links";
    if (groups == FitBoxGroups::Kinds)
        return count == 1 ? "edges" : count == 2 ? "face diagonals" : "body diagonals";
    std::string letters;
    for (int a = 0; a < 3; ++a)
        if (axes >> a & 1) letters += "xyz"[a];
    return (count == 1 ? "edges " : "diagonals ") + letters;
}

ElasticMaterial material_of(const FitBox& box) {
    return {.young_modulus_pa = box.young_modulus_pa,
            .poisson_ratio = box.poisson_ratio,
            .fibre = box.fibre,
            .fibre_young_modulus_pa = box.fibre_young_modulus_pa,
            .fibre_poisson_ratio = box.fibre_poisson_ratio,
            .fibre_shear_modulus_pa = box.fibre_shear_modulus_pa};
}

bool has_box_fibres(const FitBox& box) {
    return box.fibre.x != 0 || box.fibre.y != 0 || box.fibre.z != 0;
}

/// Young's modulus of a pull along r, relative to that across the fibres. With c the cosine between
/// the two, 1/E(r) = c⁴/E_a + (1 − c²)²/E + c² (1 − c²) (1/G_a − 2 ν_a/E_a) [Ting1996].
double stiffening_along(const FitBox& box, Vec3d r) {
    const double cosine = dot(r, box.fibre) / (norm(r) * norm(box.fibre));
    const double c2 = cosine * cosine, s2 = 1 - c2;
    const double compliance = c2 * c2 / box.fibre_young_modulus_pa +
                              s2 * s2 / box.young_modulus_pa +
                              c2 * s2 *
                                  (1 / box.fibre_shear_modulus_pa -
                                   2 * box.fibre_poisson_ratio / box.fibre_young_modulus_pa);
    return 1 / (compliance * box.young_modulus_pa);
}

/// Multiplies the starts of the groups of links with the mean stiffening along their links.
void stiffen_along_fibres(const FitBox& box, const SpringParts& parts,
                          std::vector<FitGroup>& groups) {
    for (FitGroup& group : groups) {
        if (group.links.empty()) continue;
        double sum = 0;
        for (const std::int32_t l : group.links) {
            const SpringLink& link = parts.links[std::size_t(l)];
            sum += stiffening_along(
                box, parts.nodes[std::size_t(link.b)].rest - parts.nodes[std::size_t(link.a)].rest);
        }
        const double factor = sum / double(group.links.size());
        group.start *= factor;
        group.low *= factor;
        group.high *= factor;
    }
}

std::vector<FitGroup> groups_of(const FitBox& box, const SpringParts& parts, double stiffness,
                                double bulk) {
    std::vector<FitGroup> groups;
    const auto add = [&](std::string name, double start) -> FitGroup& {
        for (FitGroup& group : groups)
            if (group.name == name) return group;
        groups.push_back({.name = std::move(name),
                          .start = start,
                          .low = start / box.range,
                          .high = start * box.range});
        return groups.back();
    };
    for (std::size_t l = 0; l < parts.links.size(); ++l)
        add(group_name(box.groups, axes_of(parts, parts.links[l])), stiffness)
            .links.push_back(std::int32_t(l));
    if (box.volume_energy)
        for (std::size_t c = 0; c < parts.cells.size(); ++c)
            add("volume", bulk).cells.push_back(std::int32_t(c));
    if (box.damping)
        for (std::size_t n = 0; n < parts.nodes.size(); ++n)
            add("damping", box.damping_start_kg_s).nodes.push_back(std::int32_t(n));
    return groups;
}

Status check(const FitBox& box) {
    if (box.loads.empty()) return bad_box("expected one or more loads, found none");
    if (!(std::isfinite(box.range) && box.range > 1))
        return bad_box("range: expected a factor above 1, found " + std::to_string(box.range));
    if (box.damping && !(std::isfinite(box.damping_start_kg_s) && box.damping_start_kg_s > 0))
        return bad_box("damping_start_kg_s: expected a number above 0, found " +
                       std::to_string(box.damping_start_kg_s));
    if (box.volume_energy && !has_box_fibres(box) && !(box.poisson_ratio > 0.25))
        return bad_box("poisson_ratio: expected more than 0.25 for a volume energy, found " +
                       std::to_string(box.poisson_ratio));
    return Ok{};
}

/// Cholesky up to some thousand nodes, conjugate gradients beyond.
Result<ElasticSolver> reference_solver(const FitBox& box, const HexLattice& lattice,
                                       std::span<const std::int32_t> held, const TaskArena& arena) {
    const ElasticMaterial material = material_of(box);
    std::vector<Support> supports;
    for (const std::int32_t n : held) supports.push_back({.node = n});
    ElasticSettings settings{.element = box.element};
    const auto nodes = std::int64_t(box.size.x) * box.size.y * box.size.z;
    if (nodes <= kMaxCholeskyNodes)
        return ElasticSolver::create(ElasticSolid{hex_mesh(lattice), {material}}, supports,
                                     settings, arena);
    settings.method = ElasticMethod::ConjugateGradients;
    settings.tolerance = kReferenceTolerance;
    if (box.element == HexElement::Trilinear && !has_box_fibres(box))
        return ElasticSolver::create(ElasticLattice{lattice, {material}}, supports, settings,
                                     arena);
    return ElasticSolver::create(ElasticSolid{hex_mesh(lattice), {material}}, supports, settings,
                                 arena);
}

}  // namespace

Result<FitBoxProblem> fit_box(const FitBox& box, const TaskArena& arena) {
    if (const Status status = check(box); !status.ok()) return status.error();
    const HexLattice lattice{box.size, box.spacing_mm};
    if (const Status status = check_lattice(lattice); !status.ok()) return status.error();
    const std::vector<std::int32_t> held = nodes_of_face(box, lattice);
    const auto solver = reference_solver(box, lattice, held, arena);
    if (!solver.ok()) return solver.error();
    auto parts = springs_of_lattice({.size = box.size,
                                     .spacing = kMetres * box.spacing_mm,
                                     .links = box.links,
                                     .node_damping = box.damping ? 1.0 : 0.0,
                                     .density = box.density_kg_per_m3,
                                     .bulk = box.volume_energy ? 1.0 : 0.0,
                                     .shared_by_cells = box.shared_by_cells});
    if (!parts.ok()) return parts.error();
    std::vector<FitCase> cases;
    for (const FitBoxLoad& load : box.loads) {
        auto nodes = loaded_nodes(box, load, lattice);
        if (!nodes.ok()) return nodes.error();
        const Vec3d force = (1.0 / double(nodes->size())) * load.force_n;
        ElasticLoads loads;
        for (const std::int32_t n : *nodes) loads.forces.push_back({n, force});
        const auto solution = solver->solve(loads);
        if (!solution.ok()) return solution.error();
        FitCase fit_case{.name = load.name,
                         .held = held,
                         .nodes = std::move(*nodes),
                         .weight = load.weight,
                         .held_out = load.held_out};
        fit_case.forces.assign(fit_case.nodes.size(), force);
        for (const Vec3d u : solution->displacement_mm) fit_case.target.push_back(kMetres * u);
        cases.push_back(std::move(fit_case));
    }
    const Vec3d h = kMetres * box.spacing_mm;
    const double side = std::cbrt(h.x * h.y * h.z);
    SpringMaterial material{0.4 * box.young_modulus_pa * side, 0};
    if (box.volume_energy)
        material = closed_form(
            box.young_modulus_pa,
            has_box_fibres(box) ? std::clamp(box.poisson_ratio, kMinStartPoisson, kMaxStartPoisson)
                                : box.poisson_ratio,
            side);
    std::vector<FitGroup> groups = groups_of(box, *parts, material.stiffness, material.bulk);
    if (has_box_fibres(box)) stiffen_along_fibres(box, *parts, groups);
    std::vector<double> start;
    for (const FitGroup& group : groups) start.push_back(group.start);
    auto problem =
        FitProblem::create(std::move(*parts), std::move(groups), std::move(cases), box.settings);
    if (!problem.ok()) return problem.error();
    const bool cubic = std::max({h.x, h.y, h.z}) < 1.01 * std::min({h.x, h.y, h.z});
    return FitBoxProblem{std::move(*problem), std::move(start), cubic};
}

}  // namespace pliant
