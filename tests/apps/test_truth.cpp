// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// `pliant truth make` and `pliant truth score`.
// Covers: pliant/run_truth*.cpp.

#include <gtest/gtest.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <fstream>

#include "support/json.h"
#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

namespace fs = std::filesystem;

class TruthTest : public ProgramInSharedFolder {
  protected:
    static void SetUpTestSuite() {
        ProgramInSharedFolder::SetUpTestSuite();
        ASSERT_EQ(run("phantom airway --size 40 --out airway.nrrd"), 0);
        ASSERT_EQ(run("truth make airway.nrrd --cases 2 --seed 5 --landmarks 30 --out t"), 0)
            << said();
    }
    static void expect_bad(const std::string& arguments, const std::string& expected) {
        EXPECT_EQ(run(arguments), 2) << arguments;
        EXPECT_NE(said().find(expected), std::string::npos) << said();
        const std::string text = said();
        EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
    }
};

TEST_F(TruthTest, Makes_all_files_of_its_cases) {
    EXPECT_TRUE(fs::exists(file("t/fixed.nrrd")));
    const Json index = Json::parse(bytes_of(file("t/truth.json")));
    ASSERT_EQ(index["cases"].size(), 2U);
    EXPECT_EQ(index["cases"][1]["seed"], 6);
    EXPECT_EQ(bytes_of(file("t/fixed.nrrd")).substr(0, 4), "NRRD");
    for (const char* one : {"t/case_0000/", "t/case_0001/"}) {
        for (const char* name : {"moving", "labels", "fixed_mask", "moving_mask"}) {
            const auto volume = read_volume(file(std::string(one) + name + ".nrrd"));
            ASSERT_TRUE(volume.ok());
            EXPECT_EQ(volume->grid.size, (Vec3i{40, 40, 40}));
        }
        const auto forward = read_vector_field(file(std::string(one) + "forward.nrrd"));
        ASSERT_TRUE(forward.ok());
        EXPECT_EQ(forward->kind, FieldKind::Modeling);
        const auto inverse = read_vector_field(file(std::string(one) + "inverse.nrrd"));
        ASSERT_TRUE(inverse.ok());
        EXPECT_EQ(inverse->kind, FieldKind::Resampling);
        const Json record = Json::parse(bytes_of(file(std::string(one) + "case.json")));
        EXPECT_LE(record["inverse_error_mm"].get<double>(), 1e-4);
        EXPECT_LE(record["landmark_error_mm"].get<double>(), 1e-4);
        EXPECT_GT(record["motions"].size(), 0U);
        EXPECT_EQ(record["settings"]["landmarks"], 30);
        std::ifstream lines(file(std::string(one) + "landmarks.csv"));
        std::string line;
        std::size_t count = 0;
        while (std::getline(lines, line)) ++count;
        EXPECT_EQ(count, record["landmarks"].get<std::size_t>() + 1);
    }
    std::size_t entries = 0;
    for (const auto& entry : fs::directory_iterator(file("t"))) entries += !entry.path().empty();
    EXPECT_EQ(entries, 4U);  // nothing is left behind
}

TEST_F(TruthTest, The_same_seed_makes_the_same_bytes_with_any_number_of_threads) {
    ASSERT_EQ(run("truth make airway.nrrd --seed 6 --landmarks 30 --threads 1 --out again"), 0);
    for (const char* name : {"moving.nrrd", "forward.nrrd", "inverse.nrrd", "labels.nrrd",
                             "fixed_mask.nrrd", "moving_mask.nrrd", "landmarks.csv", "case.json"})
        EXPECT_EQ(bytes_of(file(std::string("again/case_0000/") + name)),
                  bytes_of(file(std::string("t/case_0001/") + name)))
            << name;
}

TEST_F(TruthTest, Makes_cases_of_the_elastic_scan) {
    std::ofstream(file("moduli.toml"))
        << "[elastic]\nmoduli_kpa = [[-950, 0], [-900, 2], [40, 8]]\n";
    const std::string made = "truth make airway.nrrd --seed 4 --kinds contact --motions 1 ";
    ASSERT_EQ(run(made + "--model elastic --config moduli.toml --out soft"), 0) << said();
    ASSERT_EQ(run(made + "--model elastic --config moduli.toml --poisson-ratio 0.2 --out less"), 0)
        << said();
    ASSERT_EQ(run(made + "--out chain"), 0) << said();
    const auto record = [](const std::string& folder) {
        return Json::parse(bytes_of(file(folder + "/case_0000/case.json")));
    };
    EXPECT_EQ(record("soft")["model"], "elastic");
    EXPECT_EQ(record("chain")["model"], "chainmail");
    EXPECT_NE(record("soft")["hash"], record("less")["hash"]);
    EXPECT_LE(record("soft")["inverse_error_mm"].get<double>(), 1e-4);
    EXPECT_GT(record("soft")["max_displacement_mm"].get<double>(), 0.5);
    ASSERT_EQ(run("truth score soft --field 'same=soft/{case}/forward.nrrd' --report soft.json"), 0)
        << said();
    const Json report = Json::parse(bytes_of(file("soft.json")));
    EXPECT_EQ(report["methods"][1]["over_cases"]["moved"]["max_mm"], 0);
    expect_bad("truth make airway.nrrd --model elastic --out x",
               "--kinds: expected contact, slide or breathing");
    expect_bad("truth make airway.nrrd --poisson-ratio 0.3 --out x",
               "--poisson-ratio: expected --model elastic too, found chainmail");
    expect_bad("truth make airway.nrrd --model elastic --kinds contact --poisson-ratio 0.6 --out x",
               "--poisson-ratio");
}

TEST_F(TruthTest, Scores_the_truth_as_perfect_and_nothing_as_none) {
    ASSERT_EQ(run("truth score t --field 'same=t/{case}/forward.nrrd' --points "
                  "'marks=t/{case}/landmarks.csv' --report s.json --csv s.csv --page s.html "
                  "--markdown s.md"),
              0)
        << said();
    const Json report = Json::parse(bytes_of(file("s.json")));
    ASSERT_EQ(report["methods"].size(), 3U);
    EXPECT_EQ(report["methods"][0]["name"], "none");
    EXPECT_GT(report["methods"][0]["over_cases"]["moved"]["mean_mm"].get<double>(), 0.5);
    EXPECT_EQ(report["methods"][1]["over_cases"]["moved"]["max_mm"], 0.0);
    EXPECT_EQ(report["methods"][2]["over_cases"]["landmarks"]["max_mm"], 0.0);
    EXPECT_TRUE(report["methods"][2]["folded_share"].is_null());
    EXPECT_EQ(out(), bytes_of(file("s.md")));
    const std::string page = bytes_of(file("s.html"));
    EXPECT_NE(page.find("<svg"), std::string::npos);
    EXPECT_EQ(page.find("<script"), std::string::npos);
    EXPECT_EQ(page.find("http"), std::string::npos);
    const std::string csv = bytes_of(file("s.csv"));
    EXPECT_EQ(csv.substr(0, 17), "method,case,type,");
    ASSERT_EQ(run("truth score t --field 'same=t/{case}/forward.nrrd' --points "
                  "'marks=t/{case}/landmarks.csv' --csv again.csv --page again.html"),
              0);
    EXPECT_EQ(bytes_of(file("again.csv")), csv);
    EXPECT_EQ(bytes_of(file("again.html")), page);
}

TEST_F(TruthTest, Nifti_scores_like_nrrd) {
    ASSERT_EQ(run("truth make airway.nrrd --cases 2 --seed 5 --landmarks 30 --format nifti "
                  "--out n"),
              0)
        << said();
    ASSERT_EQ(run("truth score n --field 'f=n/{case}/forward.nii.gz' --report n.json"), 0)
        << said();
    ASSERT_EQ(run("truth score t --field 'f=n/{case}/forward.nii.gz' --report m.json"), 0)
        << said();
    ASSERT_EQ(run("truth score t --ras --field 'f=n/{case}/forward.nii.gz' --report r.json"), 0);
    const Json n = Json::parse(bytes_of(file("n.json"))), m = Json::parse(bytes_of(file("m.json"))),
               r = Json::parse(bytes_of(file("r.json")));
    EXPECT_EQ(n["methods"][1]["over_cases"]["moved"]["max_mm"], 0.0);
    EXPECT_NEAR(m["methods"][1]["over_cases"]["moved"]["max_mm"].get<double>(), 0, 1e-3);
    EXPECT_GT(r["methods"][1]["over_cases"]["moved"]["mean_mm"].get<double>(), 0.1);
}

TEST_F(TruthTest, Scores_affine_transforms_of_itk) {
    std::ofstream(file("shift.tfm")) << "#Insight Transform File V1.0\n#Transform 0\n"
                                        "Transform: AffineTransform_double_3_3\n"
                                        "Parameters: 1 0 0 0 1 0 0 0 1 0 3 4\n"
                                        "FixedParameters: 7 8 9\n";
    ASSERT_EQ(run("truth make airway.nrrd --seed 5 --out one"), 0);
    ASSERT_EQ(run("truth score one --transform shift.tfm --report a.json"), 0) << said();
    const Json a = Json::parse(bytes_of(file("a.json")));
    EXPECT_EQ(a["methods"][1]["name"], "transform");
    EXPECT_NEAR(a["methods"][1]["over_cases"]["bone"]["mean_mm"].get<double>(), 5, 1e-4);
    std::ofstream(file("spline.tfm")) << "Transform: BSplineTransform_double_3_3\n";
    expect_bad("truth score one --transform spline.tfm", "BSplineTransform");
}

TEST_F(TruthTest, Bad_input_is_one_line_and_touches_nothing) {
    expect_bad("truth make airway.nrrd --out t", "--out: expected a new or an empty folder");
    expect_bad("truth make airway.nrrd --kinds push --out x", "--kinds");
    expect_bad("truth make airway.nrrd --motions 0 --out x", "--motions");
    expect_bad("truth make gone.nrrd --out x", "gone.nrrd");
    EXPECT_FALSE(fs::exists(file("x")));
    expect_bad("truth score gone", "truth.json");
    expect_bad("truth score t --field forward.nrrd", "{case}");
    expect_bad("truth score t --field 'f=x/{case}.nrrd'", "x/case_0000.nrrd");
    expect_bad("truth score t --field 'none=t/{case}/forward.nrrd'", "a name of its own");
    expect_bad("truth score t --csv s.txt", "--csv");
    fs::create_directories(file("broken"));
    std::ofstream(file("broken/truth.json")) << "{\"format\": \"nrrd\", \"cases\": [{}]}";
    expect_bad("truth score broken", "cases");
    std::ofstream(file("few_case_0000.csv")) << "1,2,3\n";
    expect_bad("truth score t --points 'few_{case}.csv'", "expected 30 points");
    std::ofstream(file("odd_case_0000.csv")) << "# x y\n1,2\n";
    expect_bad("truth score t --points 'odd_{case}.csv'", "line 2");
}

}  // namespace
}  // namespace pliant::test
