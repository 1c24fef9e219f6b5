// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: fem/check_solid.cpp, fem/elastic_solver.cpp.

#include "fem/solids.h"

#include <limits>

namespace pliant {
namespace {

using namespace test;

const HexLattice kBlock{{3, 3, 3}};
const std::vector<Support> kFoot = hold_all({0, 1, 2, 3, 4, 5, 6, 7, 8});

ElasticSolid block(const ElasticMaterial& material = {1e5, 0.3, 1000}) {
    return {hex_mesh(kBlock), {material}};
}

std::string complaint(const ElasticSolid& solid, const std::vector<Support>& supports = kFoot,
                      const ElasticSettings& settings = {}) {
    const TaskArena arena(1);
    const auto solver = ElasticSolver::create(solid, supports, settings, arena);
    return solver.ok() ? "" : solver.error().message;
}
std::string complaint(const ElasticLoads& loads) {
    const TaskArena arena(1);
    const auto solution = value_of(ElasticSolver::create(block(), kFoot, {}, arena)).solve(loads);
    return solution.ok() ? "" : solution.error().message;
}

TEST(BadInput, Materials) {
    EXPECT_EQ(complaint(block()), "");
    EXPECT_EQ(complaint(block({-5, 0.3})),
              "materials[0]: young_modulus_pa is -5, expected a modulus above 0");
    EXPECT_EQ(complaint(block({std::numeric_limits<double>::quiet_NaN(), 0.3})),
              "materials[0]: young_modulus_pa is nan, expected a modulus above 0");
    EXPECT_EQ(complaint(block({1e5, 0.5})),
              "materials[0]: poisson_ratio is 0.5, expected a number above -1 and below 0.5");
    EXPECT_EQ(complaint(block({1e5, 0.4999})), "");
    EXPECT_EQ(complaint(block({1e5, -1})),
              "materials[0]: poisson_ratio is -1, expected a number above -1 and below 0.5");
    EXPECT_EQ(complaint(block({1e5, 0.3, -2})),
              "materials[0]: density_kg_per_m3 is -2, expected 0 or more");
    ElasticSolid solid = block();
    solid.materials.clear();
    EXPECT_EQ(complaint(solid), "materials: found none, expected one or more");
    solid = block();
    solid.material_of = {0, 0};
    EXPECT_EQ(complaint(solid), "material_of: has 2 numbers, expected 8, one for each cell");
    solid.material_of = {0, 0, 0, 1, 0, 0, 0, 0};
    EXPECT_EQ(complaint(solid), "material_of: cell 3 has material 1, expected 0…0");
}

TEST(BadInput, Meshes) {
    ElasticSolid solid = block();
    for (Vec3d& x : solid.mesh.nodes_mm) x.y = -x.y;
    EXPECT_EQ(complaint(solid),
              "mesh: cell 0 is inverted at a corner, expected a right-handed, convex one");
    solid = block();
    solid.mesh.cells[2][1] = 99;
    EXPECT_EQ(complaint(solid), "mesh: cell 2 names node 99, expected 0…26");
    solid = block();
    solid.mesh.nodes_mm.push_back({7, 7, 7});
    EXPECT_EQ(complaint(solid), "mesh: node 27 belongs to no cell, expected each to be used");
}

TEST(BadInput, SupportsThatDoNotHold) {
    const std::string free = "supports: leave the solid free to move or turn (";
    const std::string rest = " of 6 rigid motions are held), expected all 6";
    EXPECT_EQ(complaint(block(), {}), free + "0" + rest);
    EXPECT_EQ(complaint(block(), hold_all({13})), free + "3" + rest);
    EXPECT_EQ(complaint(block(), hold_all({0, 1, 2})), free + "5" + rest);  // in one line
    EXPECT_EQ(complaint(block(), hold_all({0, 1, 3})), "");
    std::vector<Support> sliding;
    for (const Support& s : kFoot) sliding.push_back({s.node, {false, false, true}});
    EXPECT_EQ(complaint(block(), sliding), free + "3" + rest);
    EXPECT_EQ(complaint(block(), hold_all({0, 27})), "supports[1]: node 27, expected 0…26");
    EXPECT_EQ(complaint(block(), {{0}, {0, {true, true, true}, {0, 2, 0}}}),
              "supports[1]: brings node 0 to 2.000000 mm along y, where another support brings it "
              "to 0.000000");
}

TEST(BadInput, AFreePieceOrAHingeIsFound) {
    ElasticSolid solid = block();
    const HexMesh other = hex_mesh({{2, 2, 2}, {1, 1, 1}, {9, 0, 0}});
    const auto first = std::int32_t(solid.mesh.nodes_mm.size());
    solid.mesh.nodes_mm.insert(solid.mesh.nodes_mm.end(), other.nodes_mm.begin(),
                               other.nodes_mm.end());
    auto cell = other.cells[0];
    for (auto& node : cell) node += first;
    solid.mesh.cells.push_back(cell);
    EXPECT_EQ(complaint(solid),
              "supports: leave the piece of node 27 free to move or turn (0 of 6 rigid motions are "
              "held), expected all 6");
    auto held = kFoot;
    for (const std::int32_t n : {27, 28, 29}) held.push_back({n});
    EXPECT_EQ(complaint(solid, held), "");

    // Two cells that share one edge: the second can turn about it.
    ElasticSolid hinge{hex_mesh({{3, 3, 2}}), {{1e5, 0.3}}};
    hinge.mesh.cells = {hinge.mesh.cells[0], hinge.mesh.cells[3]};
    std::vector<std::int32_t> number(18, -1);
    std::vector<Vec3d> nodes;
    for (auto& c : hinge.mesh.cells)
        for (auto& node : c) {
            auto& n = number[std::size_t(node)];
            if (n < 0) {
                n = std::int32_t(nodes.size());
                nodes.push_back(hinge.mesh.nodes_mm[std::size_t(node)]);
            }
            node = n;
        }
    hinge.mesh.nodes_mm = nodes;
    EXPECT_EQ(complaint(hinge, hold_all({0, 1, 2, 3, 4, 5})),
              "solid: its stiffness is singular, although it is held as a whole; expected cells "
              "that are joined by faces");
}

TEST(BadInput, Loads) {
    EXPECT_EQ(complaint({.forces = {{20, {1, 0, 0}}}}), "");
    EXPECT_EQ(complaint({.forces = {{20, {1, 0, 0}}, {27, {1, 0, 0}}}}),
              "forces[1]: node 27, expected 0…26");
    EXPECT_EQ(complaint({.forces = {{-1, {1, 0, 0}}}}), "forces[0]: node -1, expected 0…26");
    EXPECT_EQ(complaint({.forces = {{4, {0, 0, 1}}}}),
              "forces[0]: pushes node 4 along z, where it is held; expected a free component");
    EXPECT_EQ(complaint({.forces = {{20, {0, std::nan(""), 0}}}}),
              "forces[0]: force_n is not finite");
    EXPECT_EQ(complaint({.surfaces = {{{8, 0}, {1, 0, 0}}}}), "surfaces[0]: cell 8, expected 0…7");
    EXPECT_EQ(complaint({.surfaces = {{{0, 6}, {1, 0, 0}}}}), "surfaces[0]: face 6, expected 0…5");
    EXPECT_EQ(complaint({.surfaces = {{.face = {0, 0}, .pressure_pa = std::nan("")}}}),
              "surfaces[0]: traction_pa or pressure_pa is not finite");
    EXPECT_EQ(complaint({.gravity_m_per_s2 = {0, std::nan(""), 0}}),
              "gravity_m_per_s2: is not finite");
}

TEST(BadInput, SettingsAndIterationsThatDoNotSuffice) {
    EXPECT_EQ(complaint(block(), kFoot, {.tolerance = 0}),
              "tolerance: expected above 0, below 1, found 0");
    EXPECT_EQ(complaint(block(), kFoot, {.max_iterations = 0}),
              "max_iterations: expected 1 or more, found 0");
    const TaskArena arena(1);
    const ElasticLattice lattice{kBlock, {{1e5, 0.3}}};
    EXPECT_EQ(ElasticSolver::create(lattice, kFoot, {}, arena).error().message,
              "method: a lattice without a matrix has no factor, expected conjugate gradients; or "
              "make its mesh");
    EXPECT_EQ(ElasticSolver::create(lattice, kFoot,
                                    {.element = HexElement::IncompatibleModes,
                                     .method = ElasticMethod::ConjugateGradients},
                                    arena)
                  .error()
                  .message,
              "element: a lattice without a matrix has trilinear elements only; or make its mesh");
    std::vector<Support> foot;
    for (std::int32_t n = 0; n < 144; ++n) foot.push_back({n});
    const auto impatient = value_of(ElasticSolver::create(
        ElasticLattice{{{12, 12, 12}}, {{1e5, 0.3}}}, foot,
        {.method = ElasticMethod::ConjugateGradients, .max_iterations = 2}, arena));
    const auto solution = impatient.solve({.forces = {{1727, {1, 0, 0}}}});
    ASSERT_FALSE(solution.ok());
    EXPECT_EQ(solution.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(solution.error().message.rfind("max_iterations: after 2 the residual is 0.", 0), 0u);
    ElasticSolid large{hex_mesh({{28, 28, 28}}), {{1e5, 0.3}}};
    EXPECT_EQ(complaint(large, kFoot),
              "method: Cholesky with 21952 nodes, expected 20000 at most; conjugate gradients "
              "take more");
}

TEST(BadInput, StatesOfADisplacementOfAnotherLength) {
    const TaskArena arena(1);
    const auto states =
        elastic_states(block(), std::vector<Vec3d>(26), HexElement::Trilinear, arena);
    ASSERT_FALSE(states.ok());
    EXPECT_EQ(states.error().message,
              "displacement_mm: has 26 vectors, expected 27, one for each node");
}

}  // namespace
}  // namespace pliant
