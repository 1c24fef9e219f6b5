// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// `pliant fit --mesh`: tissues, measurements and curves from files; its network, used by `deform`.
// Covers: pliant/run_fit*.cpp.

#include <pliant/mesh_files.h>
#include <pliant/models/fit_mesh.h>
#include <pliant/models/pbd.h>
#include <pliant/models/scene_files.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "support/json.h"
#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

const std::string kPlaces = "--hold -1,-1,-1:31,31,1 --load 9,9,39:21,21,41:0,0,-0.4 ";
const std::string kAside = "--load 29,-1,15:31,31,35:0.2,0.1,0 ";

/// A block of 30 x 30 x 40 mm; cells above 20 mm have the label 2.
class FitMeshProgram : public ProgramInFolder {
  protected:
    FitMeshProgram() : m_mesh(five_tet_block({3, 3, 4}, 10)) {
        for (const auto& cell : m_mesh.cells) {
            double z = 0;
            for (const std::int32_t n : cell) z += 0.25 * m_mesh.nodes_mm[std::size_t(n)].z;
            m_labels.push_back(z > 20 ? 2 : 1);
        }
        EXPECT_TRUE(write_vtu(m_folder / "organ.vtu", m_mesh, {{}, {{"label", m_labels}}}).ok());
    }
    Json report() const { return Json::parse(bytes_of(m_folder / "r.json")); }
    /// Displacements of the finite elements in a file that a fit wrote.
    MeshData fitted(const char* name) const {
        auto data = read_mesh(m_folder / name);
        EXPECT_TRUE(data.ok()) << data.error().message;
        return std::move(*data);
    }

    TetMesh m_mesh;
    std::vector<double> m_labels;
};

TEST_F(FitMeshProgram, TissuesAreFittedToElementsAndTheNetworkMovesAScan) {
    ASSERT_EQ(
        run("fit --mesh organ.vtu --regions label --material 2:30000,0.4 --young 9000 --volume " +
            kPlaces + kAside +
            "--held-out 29,-1,15:31,31,35:0,-0.3,0 --threads 2 "
            "--network-out n.json --out f.vtu --report r.json"),
        0)
        << said();
    EXPECT_NE(out().find("links 2"), std::string::npos) << out();
    const Json made = report();
    EXPECT_EQ(made["mesh"], "organ.vtu");
    const Json& newton = made["methods"][1];
    EXPECT_EQ(newton["values"].size(), 4u);
    // The start is the shear modulus of each tissue.
    EXPECT_NEAR(double(made["methods"][0]["values"]["links 1"]), 9000 / 2.9, 1e-6);
    EXPECT_NEAR(double(made["methods"][0]["values"]["links 2"]), 30000 / 2.8, 1e-6);
    EXPECT_LT(double(newton["cost"]), double(made["methods"][0]["cost"]));
    for (const Json& c : newton["cases"])
        EXPECT_LT(double(c["average_percent"]), 0.15 * double(c["still_average_percent"])) << c;
    EXPECT_TRUE(newton["cases"][2]["held_out"].get<bool>());

    const auto network = read_network(m_folder / "n.json");
    ASSERT_TRUE(network.ok()) << network.error().message;
    EXPECT_EQ(network->mesh, "organ.vtu");
    ASSERT_EQ(network->groups.size(), 4u);
    EXPECT_EQ(network->groups[0].name, "links 1");
    EXPECT_EQ(network->groups[0].unit, "Pa");
    EXPECT_DOUBLE_EQ(network->groups[2].value, double(newton["values"]["links 2"]));

    const MeshData data = fitted("f.vtu");
    const auto* moved = data.field("displacement_mm_1");
    const auto* reference = data.field("reference_mm_1");
    const auto* residual = data.field("residual_mm_1");
    ASSERT_TRUE(moved && reference && residual);
    for (std::size_t n = 0; n < moved->values.size(); ++n)
        EXPECT_NEAR(residual->values[n], moved->values[n] - reference->values[n], 1e-12);
    ASSERT_TRUE(data.tetrahedron_field("region") && data.tetrahedron_field("links_pa"));
    EXPECT_EQ(data.tetrahedron_field("region")->values, m_labels);
    EXPECT_DOUBLE_EQ(data.tetrahedron_field("links_pa")->values.back(),
                     double(newton["values"]["links 2"]));

    // The same tissues from a label volume.
    Volume labels{{.size = {20, 20, 24}, .spacing_mm = {2, 2, 2}, .origin_mm = {-4, -4, -3}},
                  VoxelArray<std::int16_t>(),
                  {}};
    VoxelArray<std::int16_t> numbers(voxel_count(labels.grid));
    for (int k = 0; k < 24; ++k)
        for (int j = 3; j < 16; ++j)
            for (int i = 3; i < 16; ++i)
                numbers[voxel_index(labels.grid, {i, j, k})] = -3 + 2 * k > 20 ? 2 : 1;
    labels.voxels = std::move(numbers);
    ASSERT_TRUE(write_volume(m_folder / "l.nrrd", labels).ok());
    ASSERT_EQ(
        run("fit --mesh organ.vtu --labels l.nrrd --material 2:30000,0.4 --young 9000 --volume " +
            kPlaces + kAside + "--threads 1 --report again.json"),
        0)
        << said();
    const Json again = Json::parse(bytes_of(m_folder / "again.json"));
    EXPECT_EQ(again["methods"][1]["values"], newton["values"]);

    // The network moves a scan; its force follows.
    ASSERT_EQ(run("phantom cube --size 32 --out scan.nrrd"), 0) << said();
    ASSERT_EQ(run("deform scan.nrrd --model springs --network n.json --push 15,15,39:0,0,-4 "
                  "--tool sphere:9 --out o.nrrd --report d.json --save-state s.plst"),
              0)
        << said();
    const Json saved = Json::parse(bytes_of(m_folder / "d.json"));
    ASSERT_EQ(run("deform scan.nrrd --model springs --network n.json --load-state s.plst "
                  "--steps 0 --out p.nrrd --report e.json"),
              0)
        << said();
    EXPECT_EQ(Json::parse(bytes_of(m_folder / "e.json"))["max_movement_mm"],
              saved["max_movement_mm"]);
    // A sphere from above touches the block's upper face, and tissue slides off it.
    ASSERT_EQ(run("deform scan.nrrd --model springs --network n.json --slide 15,15,52:0,0,-8 "
                  "--tool sphere:6 --out o.nrrd --report e.json"),
              0)
        << said();
    const Json slid = Json::parse(bytes_of(m_folder / "e.json"));
    EXPECT_GT(double(slid["max_movement_mm"]), 1);
    EXPECT_GT(double(slid["springs"]["force_n"][2]), 0.01);
    ASSERT_EQ(run("deform scan.nrrd --model springs --network n.json --push 15,15,39:0,0,-4 "
                  "--tool sphere:9 --out o.nrrd --report d.json"),
              0)
        << said();
    EXPECT_NE(out().find("steps of 16.7 ms (at rest)"), std::string::npos) << out();
    const Json deformed = Json::parse(bytes_of(m_folder / "d.json"));
    EXPECT_EQ(deformed["network"]["network_nodes"], 80);
    EXPECT_NEAR(double(deformed["max_movement_mm"]), 4, 0.1);
    EXPECT_GT(double(deformed["springs"]["force_n"][2]), 0.1);
}

TEST_F(FitMeshProgram, MeasurementsGiveTheTruthWithItsInterval) {
    ASSERT_EQ(run("fit --mesh organ.vtu --young 8000 --volume " + kPlaces + kAside +
                  "--method closed-form --out truth.vtu --report r.json"),
              0)
        << said();
    const Json truth = report()["methods"][0]["values"];
    const MeshData data = fitted("truth.vtu");
    for (const int load : {1, 2}) {
        const auto* moved = data.field("displacement_mm_" + std::to_string(load));
        ASSERT_TRUE(moved);
        std::string text = load == 1 ? "node,dx,dy,dz\n" : "# markers\nx,y,z,dx,dy,dz\n";
        for (std::size_t n = 20; n < 80; n += 2) {
            char row[300];
            const Vec3d p = data.nodes_mm[n];
            const double* u = &moved->values[3 * n];
            if (load == 1)
                std::snprintf(row, sizeof row, "%zu,%.17g,%.17g,%.17g\n", n, u[0], u[1], u[2]);
            else
                std::snprintf(row, sizeof row, "%g; %g; %g; %.17g; %.17g; %.17g\r\n", p.x, p.y, p.z,
                              u[0], u[1], u[2]);
            text += row;
        }
        write(load == 1 ? "one.csv" : "two.csv", text);
    }
    const std::string measured = "fit --mesh organ.vtu --young 20000 --volume --range 50 " +
                                 kPlaces + "--target one.csv " + kAside + "--target two.csv ";
    ASSERT_EQ(run(measured + "--noise-mm 0.02 --cost squares --method gauss-newton --report r.json "
                             "--network-out n.json"),
              0)
        << said();
    EXPECT_NE(out().find("(95 %: "), std::string::npos) << out();
    const Json found = report()["methods"][0];
    for (const char* name : {"links", "volume"}) {
        const double value = truth[name];
        EXPECT_NEAR(double(found["values"][name]) / value, 1, 1e-4);
        EXPECT_LT(double(found["intervals_95"][name]["low"]), value);
        EXPECT_GT(double(found["intervals_95"][name]["high"]), value);
    }
    EXPECT_LT(double(found["residual_rms_mm"]), 1e-6);
    const auto network = read_network(m_folder / "n.json");
    ASSERT_TRUE(network.ok());
    EXPECT_DOUBLE_EQ(network->groups[0].low, double(found["intervals_95"]["links"]["low"]));
    // Bounds on the wrong side of the truth are told in text and JSON.
    ASSERT_EQ(run("fit --mesh organ.vtu --young 20000 --volume --range 1.5 " + kPlaces +
                  "--target one.csv " + kAside +
                  "--target two.csv --report r.json --network-out n.json "
                  "--method gauss-newton"),
              0)
        << said();
    EXPECT_NE(out().find("at its lower bound"), std::string::npos) << out();
    EXPECT_EQ(report()["methods"][0]["at_bound"]["links"]["bound"], "lower");
    EXPECT_EQ(read_network(m_folder / "n.json")->groups[0].note, "at its lower bound");
    // A network of links can't have the volumes of this one: more than the noise is left.
    ASSERT_EQ(
        run("fit --mesh organ.vtu --young 20000 --range 50 " + kPlaces + "--target one.csv " +
            kAside + "--target two.csv --noise-mm 0.001 --method gauss-newton --report r.json"),
        0)
        << said();
    EXPECT_NE(out().find("larger than the noise"), std::string::npos) << out();
    EXPECT_TRUE(report()["methods"][0].contains("note"));
}

TEST_F(FitMeshProgram, ACurveOfCreepGivesTheDamping) {
    FitMesh f{.mesh = m_mesh};
    for (std::size_t n = 0; n < m_mesh.nodes_mm.size(); ++n) {
        const Vec3d p = m_mesh.nodes_mm[n];
        if (p.z < 1) f.held.push_back(std::int32_t(n));
        if (p.z > 39 && p.x > 9 && p.x < 21 && p.y > 9 && p.y < 21) {
            f.loads.resize(1);
            f.loads[0].nodes.push_back(std::int32_t(n));
        }
    }
    f.loads[0].force_n = {0, 0, -0.4};
    const TaskArena arena(2);
    const auto problem = fit_mesh(f, arena);
    ASSERT_TRUE(problem.ok()) << problem.error().message;
    SpringParts parts = problem->problem.parts_at(problem->closed_form);
    for (SpringNode& node : parts.nodes) node.damping = 900 * node.mass;
    auto tissue = SpringTissue::create(std::move(*SpringNetwork::create(std::move(parts))),
                                       {.solver = SpringSolver::Explicit});
    ASSERT_TRUE(tissue.ok());
    const std::int32_t node = f.loads[0].nodes[0];
    // A small part of the load, so that displacements are small.
    std::vector<Vec3d> forces(f.loads[0].nodes.size(),
                              {0, 0, -400.0 / double(f.loads[0].nodes.size())});
    ASSERT_TRUE(tissue->load(f.loads[0].nodes, forces).ok());
    std::string text = "time_s,node,dx,dy,dz\n";
    for (int n = 1; n <= 30; ++n) {
        const int steps = 20;
        ASSERT_TRUE(tissue->step(steps, arena).ok());
        char row[200];
        const Vec3d u = 1e3 * tissue->displacement(node);
        std::snprintf(row, sizeof row, "%.9g,%d,%.9g,%.9g,%.9g\n", n * steps * tissue->time_step(),
                      node, u.x, u.y, u.z);
        text += row;
    }
    write("creep.csv", text);
    ASSERT_EQ(run("fit --mesh organ.vtu " + kPlaces +
                  "--method closed-form --creep creep.csv --noise-mm 0.01 --network-out n.json "
                  "--report r.json"),
              0)
        << said();
    EXPECT_NE(out().find("damping"), std::string::npos) << out();
    const Json creep = report()["creep"];
    EXPECT_NEAR(double(creep["damping_per_s"]), 900, 45) << creep;
    EXPECT_LT(double(creep["interval_95"][0]), double(creep["damping_per_s"]));
    const auto network = read_network(m_folder / "n.json");
    ASSERT_TRUE(network.ok());
    EXPECT_EQ(network->groups.back().name, "damping");
    EXPECT_NEAR(network->parts.nodes[40].damping,
                double(creep["damping_per_s"]) * network->parts.nodes[40].mass, 1e-9);
}

TEST_F(FitMeshProgram, ABoxHasIntervalsInTheUnitsOfItsNetwork) {
    const std::string box =
        "fit --size 4,4,4 --spacing 20 --load +z:0,0,-10 --damping 3 --method closed-form ";
    ASSERT_EQ(run(box + "--noise-mm 0.01 --report r.json"), 0) << said();
    const Json one = report()["methods"][0];
    const double stiffness = one["values"]["links"];
    const double low = one["intervals_95"]["links"]["low"];
    const double high = one["intervals_95"]["links"]["high"];
    EXPECT_NEAR(low * high / (stiffness * stiffness), 1, 1e-9);
    EXPECT_FALSE(one["intervals_95"]["damping"]["identifiable"].get<bool>());
    // The displacements follow from the force, J = -u, and so does the interval's width.
    ASSERT_EQ(run(box + "--noise-mm 0.02 --report r.json"), 0) << said();
    const Json two = report()["methods"][0]["intervals_95"]["links"];
    EXPECT_NEAR(std::log(double(two["high"]) / double(two["low"])), 2 * std::log(high / low), 1e-9);
    EXPECT_GT(high / low, 1.001);
    EXPECT_LT(high / low, 1.5);
    ASSERT_EQ(run(box + "--report r.json"), 0) << said();
    EXPECT_FALSE(report()["methods"][0].contains("intervals_95"));
}

TEST_F(FitMeshProgram, AnnealingFindsTwoTissues) {
    const std::string tissues =
        "fit --mesh organ.vtu --regions label --material 1:9000 --material 2:36000 " + kPlaces +
        kAside + "--report r.json --threads 2 ";
    ASSERT_EQ(run(tissues + "--method gauss-newton"), 0) << said();
    const Json best = report()["methods"][0];
    for (const int seed : {1, 2, 3}) {
        SCOPED_TRACE(seed);
        ASSERT_EQ(
            run(tissues + "--method annealing --evaluations 1500 --seed " + std::to_string(seed)),
            0)
            << said();
        const Json found = report()["methods"][0];
        EXPECT_LT(double(found["cost"]), 1.05 * double(best["cost"]));
        const double soft = found["values"]["links 1"], hard = found["values"]["links 2"];
        EXPECT_NEAR(soft / double(best["values"]["links 1"]), 1, 0.05);
        EXPECT_NEAR(hard / double(best["values"]["links 2"]), 1, 0.25);
        // Of the materials: 4.
        EXPECT_GT(hard / soft, 3);
        EXPECT_LT(hard / soft, 5.5);
    }
}

TEST_F(FitMeshProgram, ABoxWithFibresNeedsSpringsByDirection) {
    const std::string box =
        "fit --size 5,5,5 --spacing 5 --young 12500 --poisson 0.25 --fibre 1,0,0 "
        "--fibre-young 33600 --fibre-poisson 0.4 --fibre-shear 8000 --by-cells "
        "--load +z:0,0,0.01:0.5,0.5:5 --load +z:0.01,0,0:0.5,0.5:5 --load +z:0,0.01,0:0.5,0.5:5 "
        "--load +x:0.01,0,0:0.5,0.7:4 --load +y:0,0.01,0:0.5,0.7:4 "
        "--held-out +z:-0.005,-0.005,-0.01:0.8,0.8:2 --report r.json ";
    ASSERT_EQ(run(box + "--groups directions"), 0) << said();
    EXPECT_NE(out().find("with fibres it is only a start"), std::string::npos) << out();
    const Json by_direction = report();
    EXPECT_EQ(by_direction["reference"]["fibre_young_modulus_pa"], 33600);
    EXPECT_EQ(by_direction["reference"]["young_modulus_pa"], 12500);
    const Json& found = by_direction["methods"][1];
    EXPECT_EQ(found["values"].size(), 6u);
    EXPECT_GT(double(found["values"]["edges x"]), 4 * double(found["values"]["edges y"]));
    EXPECT_NEAR(double(found["values"]["edges y"]) / double(found["values"]["edges z"]), 1, 0.3);
    ASSERT_EQ(run(box + "--groups uniform"), 0) << said();
    const auto held_out = [](const Json& method) {
        return double(method["cases"].back()["average_percent"]);
    };
    EXPECT_TRUE(found["cases"].back()["held_out"].get<bool>());
    EXPECT_LT(held_out(found), 0.5 * held_out(report()["methods"][1]));

    const std::string small = "fit --size 3,3,3 --report no.json ";
    for (const auto& [arguments, text] :
         {std::pair<std::string, const char*>{
              small + "--fibre 1,0,0", "--fibre-young: expected a number beside --fibre, found "},
          {small + "--fibre 1,0,0 --fibre-young 5 --fibre-poisson 0.3",
           "--fibre-shear: expected a number beside --fibre, found none"},
          {small + "--fibre-young 5", "--fibre-young: expected --fibre X,Y,Z too, found none"},
          {small + "--fibre 1,0 --fibre-young 5 --fibre-poisson 0.3 --fibre-shear 2",
           "--fibre: expected a direction of three numbers, found '1,0'"},
          {small + "--fibre 0,0,0 --fibre-young 5 --fibre-poisson 0.3 --fibre-shear 2",
           "--fibre: expected a direction of three numbers, found '0,0,0'"},
          {small + "--fibre 1,0,0 --fibre-young -5 --fibre-poisson 0.3 --fibre-shear 2",
           "--fibre-young: expected a modulus above 0, found -5"},
          {small + "--fibre 1,0,0 --fibre-young 5 --fibre-poisson 9 --fibre-shear 2",
           "fibre_poisson_ratio is 9"},
          {"fit --mesh organ.vtu " + kPlaces + kAside + "--fibre 1,0,0", "--fibre"}}) {
        EXPECT_EQ(run(arguments), 2) << arguments;
        EXPECT_NE(said().find(text), std::string::npos) << arguments << ": " << said();
    }
    EXPECT_FALSE(names().count("no.json"));
}

TEST_F(FitMeshProgram, WarnsOfLoadsThatAreTooLargeForLinearElements) {
    const std::string small =
        "fit --size 4,4,4 --spacing 10 --young 10000 --method closed-form "
        "--report r.json --load +z:0,0,-0.02 ";
    ASSERT_EQ(run(small), 0) << said();
    EXPECT_EQ(out().find("warning: "), std::string::npos) << out();
    EXPECT_FALSE(report().contains("warnings"));
    ASSERT_EQ(run(small + "--load +z:2,0,0"), 0) << said();
    EXPECT_NE(out().find("warning: load +z:2,0,0: moves up to "), std::string::npos) << out();
    EXPECT_NE(out().find("too far for linear elements"), std::string::npos) << out();
    ASSERT_EQ(report()["warnings"].size(), 1u);
    ASSERT_EQ(run("fit --mesh organ.vtu --young 9000 --method closed-form --report r.json " +
                  kPlaces + "--held-out 29,-1,15:31,31,35:20,0,0"),
              0)
        << said();
    ASSERT_EQ(report()["warnings"].size(), 1u) << report()["warnings"];
    EXPECT_EQ(report()["warnings"][0].get<std::string>().find("load 29,-1,15:31,31,35:20,0,0: "),
              0u);
}

TEST_F(FitMeshProgram, ASurfaceIsFilled) {
    ASSERT_TRUE(write_surface(m_folder / "organ.stl", boundary_triangles(m_mesh)).ok());
    ASSERT_EQ(run("fit --mesh organ.stl --tetrahedra 400 --hold -1,-1,-1:31,31,6 "
                  "--load 0,0,35:30,30,41:0,0,-0.4 --network-out n.json"),
              0)
        << said();
    const auto network = read_network(m_folder / "n.json");
    ASSERT_TRUE(network.ok());
    EXPECT_GT(network->parts.cells.size(), 150u);
    EXPECT_LT(network->parts.cells.size(), 1000u);
}

TEST_F(FitMeshProgram, FaultsAreToldInALine) {
    write("bad.csv", "node,dx,dy,dz\n1,0,0,0\n2,0,0\n");
    write("three.csv", "1,2,3\n");
    write("far.csv", "500,0,0,0,0,0\n");
    write("node.csv", "80,0,0,0\n");
    write("text.csv", "1,0,0,x\n");
    write("empty.csv", "# nothing\n");
    const std::string fit = "fit --mesh organ.vtu ";
    const std::pair<std::string, const char*> cases[] = {
        {"fit --mesh none.vtu " + kPlaces, "--mesh: none.vtu: expected a file, found none"},
        {fit + "--load 9,9,39:21,21,41:0,0,-1",
         "--hold: expected X,Y,Z:X,Y,Z or NAME=VALUE, found none"},
        {fit + "--hold -1,-1,-1:31,31,1", "--load: expected one or more, found none"},
        {fit + "--hold 1,2:3 " + kAside,
         "--hold: expected X,Y,Z:X,Y,Z or NAME=VALUE, found '1,2:3'"},
        {fit + "--hold 90,0,0:91,1,1 " + kAside, "--hold: expected a place with nodes of the mesh"},
        {fit + "--hold organ=1 " + kAside,
         "--hold: expected an array of numbers in the mesh's file"},
        {fit + "--hold label=x " + kAside, "--hold: expected X,Y,Z:X,Y,Z or NAME=VALUE"},
        {fit + kPlaces + "--load label=2", "--load: expected X,Y,Z:X,Y,Z:FX,FY,FZ"},
        {fit + "--hold label=1 --load label=1:0,0,1", "--load: expected nodes that aren't held"},
        {fit + kPlaces + "--target bad.csv", "--target: bad.csv: line 3: expected finite numbers"},
        {fit + kPlaces + "--target bad.csv --target bad.csv",
         "--target: expected one for each of 1 loads"},
        {fit + kPlaces + "--target three.csv",
         "expected the columns node,dx,dy,dz or x,y,z,dx,dy,dz"},
        {fit + kPlaces + "--target far.csv", "mm of the mesh, its mean edge"},
        {fit + kPlaces + "--target node.csv", "node.csv: expected nodes below 80, found 80"},
        {fit + kPlaces + "--target text.csv", "text.csv: line 1: expected finite numbers"},
        {fit + kPlaces + "--target empty.csv", "empty.csv: expected lines of numbers, found none"},
        {fit + kPlaces + "--target organ.vtu:u", "expected an array 'u' of vectors, found none"},
        {fit + kPlaces + "--regions none", "--regions: expected an array of numbers"},
        {fit + kPlaces + "--material 1:5", "--material: expected --regions or --labels too"},
        {fit + kPlaces + "--regions label --material 3:5000",
         "--material: expected a label of the mesh"},
        {fit + kPlaces + "--regions label --material 1",
         "--material: expected LABEL:YOUNG[,POISSON]"},
        {fit + kPlaces + "--volume --poisson 0.2", "Poisson's ratio above 0.25"},
        {fit + kPlaces + "--motion run", "--motion: expected linear or equilibrium with --mesh"},
        {fit + kPlaces + "--creep three.csv", "expected the columns time_s,node,dx,dy,dz, found 3"},
        {fit + kPlaces + "--size 3,3,3", "--size"},
        {"fit --hold label=1", "--mesh"},
        {fit + kPlaces + "--network-out no/n.json", "no/n.json"},
    };
    for (const auto& [arguments, text] : cases) {
        EXPECT_EQ(run(arguments), 2) << arguments;
        EXPECT_NE(said().find(text), std::string::npos) << arguments << ": " << said();
        const std::string line = said();
        EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
    }
    ASSERT_EQ(run("phantom cube --size 16 --out scan.nrrd"), 0);
    const std::string deform = "deform scan.nrrd --push 0,0,0:0,0,1 --out o.nrrd ";
    write("n.json", "{}");
    for (const auto& [arguments, text] :
         {std::pair<std::string, const char*>{deform + "--model springs --network n.json",
                                              "--network: n.json: format: expected"},
          {deform + "--model springs --network x.json",
           "--network: x.json: expected a network of pliant fit"},
          {deform + "--network n.json", "--network: expected --model springs too"},
          {deform + "--model springs --reach-mm 4",
           "--reach-mm: expected --network too, found none"},
          {deform + "--solve-tolerance 0.1", "--solve-tolerance: expected --model springs too"},
          {deform + "--model springs --network n.json --depth 4",
           "--depth: expected none beside --network"}}) {
        EXPECT_EQ(run(arguments), 2) << arguments;
        EXPECT_NE(said().find(text), std::string::npos) << arguments << ": " << said();
    }
    EXPECT_EQ(names(),
              (std::set<std::string>{"bad.csv", "empty.csv", "far.csv", "n.json", "node.csv",
                                     "organ.vtu", "scan.nrrd", "text.csv", "three.csv"}));
}

}  // namespace
}  // namespace pliant::test
