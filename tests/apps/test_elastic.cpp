// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The elastic scan on the command line.
// Covers: pliant/deform_models.cpp.

#include <gtest/gtest.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "support/json.h"
#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

class ElasticProgram : public ProgramInSharedFolder {
  protected:
    static void SetUpTestSuite() {
        ProgramInSharedFolder::SetUpTestSuite();
        ASSERT_EQ(run("phantom cube --size 48 --out cube.nrrd"), 0);
    }
    static Json deform_report(const std::string& arguments) {
        EXPECT_EQ(run("deform " + arguments + " --out r.nrrd --report r.json"), 0) << said();
        return Json::parse(bytes_of(file("r.json")));
    }
};

TEST_F(ElasticProgram, DeformsWithTheOutputsOfOtherModels) {
    // Air is as stiff as tissue: a block that its sides hold.
    const auto write_moduli = [](const char* name, double kpa) {
        std::ofstream(file(name)) << "[material]\noffset = 0.1\n[elastic]\nmoduli_kpa = [[0, "
                                  << kpa << "]]\nheld_above_hu = 3000\n";
    };
    write_moduli("stiff.toml", 20);
    write_moduli("soft.toml", 2);
    const std::string push = "cube.nrrd --model elastic --tool sphere:3 --push 0,0,0:1,3,0 ";
    const Json report = deform_report(push +
                                      "--config stiff.toml --displacement eu.nrrd --transform "
                                      "et.nrrd --jacobian ej.nrrd --png e.png --threads 1");
    for (const char* key :
         {"status", "limited_by", "step_fraction", "moved_elements", "max_violation_mm",
          "folded_cells", "solve_ms", "resample_ms", "dirty_box_ijk", "resident_bricks",
          "bytes_per_resident_element", "peak_memory_mb", "hash"})
        EXPECT_TRUE(report.contains(key)) << key;
    EXPECT_EQ(report["model"], "elastic");
    EXPECT_EQ(report["status"], "applied");
    EXPECT_EQ(report["folded_cells"], 0);
    const Json& elastic = report["elastic"];
    EXPECT_EQ(elastic["settled"], true);
    EXPECT_GT(elastic["steps"], 0);
    EXPECT_GT(elastic["nodes"], 1000);
    EXPECT_LT(elastic["force_n"][1], -0.1);
    const auto forward = read_vector_field(file("eu.nrrd"));
    ASSERT_TRUE(forward.ok());
    const Vec3d p = voxel_from_world(forward->grid, {0, 0, 0});
    const Vec3f there = forward->vectors_mm[voxel_index(
        forward->grid, {int(std::lround(p.x)), int(std::lround(p.y)), int(std::lround(p.z))})];
    EXPECT_NEAR(there.x, 1, 1e-3);
    EXPECT_NEAR(there.y, 3, 1e-3);
    EXPECT_TRUE(std::filesystem::exists(file("e.png")));
    // A tenth of the modulus is a tenth of the force.
    const Json soft = deform_report(push + "--config soft.toml --threads 4");
    EXPECT_NEAR(soft["elastic"]["force_n"][1], 0.1 * double(elastic["force_n"][1]),
                1e-4 * std::abs(double(elastic["force_n"][1])));
    EXPECT_EQ(deform_report(push + "--config stiff.toml --threads 4")["hash"], report["hash"]);
    EXPECT_NE(deform_report(push + "--config stiff.toml --poisson-ratio 0.3")["hash"],
              report["hash"]);
    EXPECT_EQ(deform_report(push + "--config stiff.toml --release")["moved_elements"], 0);
    // The cube is bone for the default threshold, and the same file has ChainMail's settings.
    EXPECT_EQ(deform_report(push)["moved_elements"], 0);
    EXPECT_EQ(deform_report("cube.nrrd --config stiff.toml --push 0,0,0:1,0,0")["model"],
              "chainmail");
}

TEST_F(ElasticProgram, SlidesAndSavesItsState) {
    ASSERT_EQ(run("phantom airway --size 48 --out airway.nrrd"), 0);
    std::ofstream(file("airway.toml")) << "[elastic]\npoisson_ratio = 0.3\n";
    const std::string scan = "airway.nrrd --model elastic --config airway.toml ";
    const Json saved = deform_report(scan +
                                     "--tool sphere:4 --slide=-2,-2,10:-8,1,-3 --steps 2 "
                                     "--save-state e.plst");
    ASSERT_EQ(saved["slides"].size(), 1);
    EXPECT_GT(saved["slides"][0]["contacts"], 0);
    EXPECT_GT(saved["elastic"]["force_n"][0], 0);
    EXPECT_GT(saved["moved_elements"], 100);
    EXPECT_EQ(deform_report(scan + "--load-state e.plst --steps 0")["hash"], saved["hash"]);
}

TEST_F(ElasticProgram, MistakesAreOneLineAndStatusTwo) {
    std::ofstream(file("bad.toml")) << "[elastic]\nmoduli_kpa = [[1, 2], [0, 3]]\n";
    for (const auto& [options, message] : {
             std::pair(
                 "--model elastic --config bad.toml",
                 "bad.toml: [elastic] moduli_kpa: expected ascending values, found 0 after 1"),
             {"--model elastic --relax 3", "--relax: expected --model chainmail"},
             {"--model elastic --poisson-ratio 0.5", "--poisson-ratio: expected 0 to 0.495"},
             {"--held-above-hu 3", "--held-above-hu: expected --model elastic too"},
         }) {
        EXPECT_EQ(run("deform cube.nrrd --push 0,0,0:1,0,0 --out x.nrrd " + std::string(options)),
                  2);
        EXPECT_NE(said().find(message), std::string::npos) << said();
        EXPECT_FALSE(std::filesystem::exists(file("x.nrrd")));
    }
}

TEST_F(ElasticProgram, TakesModuliFromLabels) {
    auto labels = read_volume(file("cube.nrrd"));
    ASSERT_TRUE(labels.ok());
    std::vector<std::int16_t> values(voxel_count(labels->grid), 5);
    labels->voxels = std::move(values);
    ASSERT_TRUE(write_volume(file("labels.nrrd"), *labels).ok());
    const auto force = [&](const std::string& kpa) {
        std::ofstream(file("labels.toml")) << "[elastic]\nheld_above_hu = 3000\n[[label]]\n"
                                              "values = [5]\nelastic = ["
                                           << kpa << ", 0.45]\n";
        return deform_report(
                   "cube.nrrd --model elastic --tool sphere:3 --push 0,0,0:0,1,0 --config "
                   "labels.toml --labels labels.nrrd")["elastic"]["force_n"][1]
            .get<double>();
    };
    EXPECT_NEAR(force("30") / force("10"), 3, 0.05);
}

TEST_F(ElasticProgram, CutsAndCarves) {
    const Json report = deform_report(
        "cube.nrrd --model elastic --cut \"-5,0,-5;5,0,-5:0,0,10\" --carve 0,8,0:2 "
        "--tool sphere:2 --push 0,3,0:0,1,0");
    EXPECT_GT(report["cut_links"], 0);
    EXPECT_GT(report["carved_elements"], 0);
}

}  // namespace
}  // namespace pliant::test
