// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scans that are no CT in HU, out of the box.
// Covers: volume/scan_values.cpp.

#include <gtest/gtest.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "support/made.h"
#include "support/program_in_folder.h"
#include "support/random.h"
#include "support/scan_files.h"

namespace pliant::test {
namespace {

constexpr int kSide = 56;

/// A ball of tissue with a shell of bone and a tube of air through it, in the grey values of a kind
/// of scan.
struct ScanKind {
    const char* name;
    double air, soft, bone, noise, spacing_mm;
};
constexpr ScanKind kKinds[] = {
    {"mr.nrrd", 25, 7000, 800, 15, 2},
    {"normalised.nrrd", 0.03, 0.45, 0.9, 0.02, 2},
    {"cbct.nrrd", 60, 1080, 2000, 25, 1.5},
    {"microct.nrrd", 9000, 24000, 52000, 900, 0.02},
    {"microct_hu.nrrd", -1000, 40, 900, 20, 0.02},
    {"ultrasound.nrrd", 12, 110, 180, 8, 0.4},
};

double value_at(const ScanKind& kind, Vec3d p, Random& random) {
    const double middle = 0.5 * (kSide - 1), r = norm(p - Vec3d{middle, middle, middle});
    const bool tube = std::hypot(p.x - middle, p.y - middle - 3) < 5 + std::sin(p.z / 6) && r < 25;
    const double grey = tube || r > 24 ? kind.air : r > 21 ? kind.bone : kind.soft;
    return grey + kind.noise * random.real(-1, 1);
}

class KindsOfScans : public ProgramInFolder {
  protected:
    void write_scan(const ScanKind& kind) {
        Random random(1);
        const bool whole = kind.noise > 1;
        std::vector<float> values;
        for (int z = 0; z < kSide; ++z)
            for (int y = 0; y < kSide; ++y)
                for (int x = 0; x < kSide; ++x) {
                    const double v = value_at(kind, {double(x), double(y), double(z)}, random);
                    values.push_back(float(whole ? std::round(v) : v));
                }
        const std::string s = std::to_string(kind.spacing_mm);
        NrrdFile file;
        file.type = "float";
        file.sizes =
            std::to_string(kSide) + " " + std::to_string(kSide) + " " + std::to_string(kSide);
        file.directions = "(" + s + ",0,0) (0," + s + ",0) (0,0," + s + ")";
        file.origin = "(0,0,0)";
        file.data = packed(values);
        write(kind.name, file.bytes());
    }

    /// Commands that `info --suggest-push` recommends.
    std::vector<std::string> recommended() const {
        std::vector<std::string> commands;
        const std::string text = out();
        for (std::size_t at = 0; (at = text.find("pliant ", at)) != text.npos; ++at)
            commands.push_back(text.substr(at + 7, text.find('\n', at) - at - 7));
        return commands;
    }

    std::pair<float, float> values_of(const char* name) const {
        const Volume volume = made(read_volume(m_folder / name));
        float low = volume.at({0, 0, 0}), high = low;
        for (int z = 0; z < kSide; ++z)
            for (int y = 0; y < kSide; ++y)
                for (int x = 0; x < kSide; ++x) {
                    low = std::min(low, volume.at({x, y, z}));
                    high = std::max(high, volume.at({x, y, z}));
                }
        return {low, high};
    }
};

TEST_F(KindsOfScans, WhatInfoRecommendsWorks) {
    for (const ScanKind& kind : kKinds) {
        SCOPED_TRACE(kind.name);
        write_scan(kind);
        ASSERT_EQ(run(std::string("info ") + kind.name + " --suggest-push"), 0) << said();
        EXPECT_EQ(out().find(" HU") == std::string::npos, kind.air > -500) << out();
        const auto commands = recommended();
        ASSERT_EQ(commands.size(), 2u) << out();
        for (const std::string& command : commands)
            EXPECT_EQ(run(command + (command.starts_with("deform") ? " --report r.json" : "")), 0)
                << command << "\n"
                << said();
        const auto report = nlohmann::json::parse(bytes_of(m_folder / "r.json"));
        EXPECT_EQ(report["status"], "applied") << report.dump(1);
        // Nothing comes from outside of the scan's own values.
        const auto before = values_of(kind.name), after = values_of("pushed.nrrd");
        EXPECT_GE(after.first, before.first);
        EXPECT_LE(after.second, before.second);
        for (const char* picture : {"view.png", "pushed.png"}) {
            EXPECT_TRUE(exists(picture));
            std::filesystem::remove(m_folder / picture);
        }
    }
}

TEST_F(KindsOfScans, JsonHasTheKindAndTheDefaults) {
    write_scan(kKinds[0]);
    ASSERT_EQ(run("info mr.nrrd --json"), 0) << said();
    const auto json = nlohmann::json::parse(out());
    EXPECT_EQ(json["taken_as"], "values without a unit");
    EXPECT_EQ(json["unit"], "");
    EXPECT_EQ(json["modality"], "");
    EXPECT_EQ(json["defaults"]["polarity"], "rising");
    EXPECT_EQ(json["defaults"]["background"], json["min"]);
    EXPECT_GT(json["defaults"]["iso"], 1000);
}

TEST_F(KindsOfScans, DeformSaysInOneLineWhatWasChosenAndHowToChangeIt) {
    write_scan(kKinds[0]);
    ASSERT_EQ(run("deform mr.nrrd --push 55,30,55:0,-3,0 --tool sphere:5 --out o.nrrd"), 0)
        << said();
    EXPECT_NE(out().find("taken as values without a unit (by the histogram); defaults: window "),
              std::string::npos)
        << out();
    EXPECT_NE(out().find("; change with --window, --level"), std::string::npos);
    write_scan(kKinds[4]);
    ASSERT_EQ(run("deform microct_hu.nrrd --push .55,.3,.55:0,-.03,0 --tool sphere:0.08 "
                  "--out o.nrrd"),
              0)
        << said();
    EXPECT_EQ(out().find("taken as"), std::string::npos) << out();
}

TEST_F(KindsOfScans, SettingsOfTheUserComeFirst) {
    write_scan(kKinds[0]);
    write("bone.toml", "[material]\nbone_threshold_hu = 3000\n");
    ASSERT_EQ(run("deform mr.nrrd --config bone.toml --push 55,30,55:0,-3,0 --tool sphere:5 "
                  "--out o.nrrd --report -"),
              0)
        << said();
    EXPECT_EQ(nlohmann::json::parse(out())["status"], "rejected") << out();
    ASSERT_EQ(run("render mr.nrrd --view axial --window 10 --level 5 --out dark.png"), 0);
    ASSERT_EQ(run("render mr.nrrd --view axial --out view.png"), 0);
    EXPECT_NE(bytes_of(m_folder / "dark.png"), bytes_of(m_folder / "view.png"));
    ASSERT_EQ(run("deform mr.nrrd --push 55,30,55:0,-3,0 --window 10 --level 5 --polarity falling "
                  "--out o.nrrd --png dark.png"),
              0)
        << said();
}

TEST_F(KindsOfScans, AScanWithoutALumenIsSeenFromOutside) {
    NrrdFile file;
    file.data = packed(std::vector<std::int16_t>(24, 700));
    write("block.nrrd", file.bytes());
    for (const char* view : {"blended", "four-up", "endoscope"})
        EXPECT_EQ(run(std::string("render block.nrrd --view ") + view + " --out view.png"), 0)
            << view << said();
    // A threshold of the user's is taken at its word.
    EXPECT_EQ(run("render block.nrrd --iso -500 --out view.png"), 2);
    EXPECT_NE(said().find("no lumen at --iso"), std::string::npos) << said();
}

}  // namespace
}  // namespace pliant::test
