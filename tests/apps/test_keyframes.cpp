// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The page's keyframes, read and turned into the page's cameras.
// Covers: pliant/keyframes.cpp.

#include "../../apps/pliant/keyframes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "support/json.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

Json frame(double seconds, Vec3d eye, Vec3d look, Vec3d up, double field, double iso, double window,
           double level) {
    const auto list = [](Vec3d v) { return Json{v.x, v.y, v.z}; };
    return {{"seconds", seconds},  {"eye_mm", list(eye)}, {"look", list(look)},
            {"up", list(up)},      {"iso_hu", iso},       {"field_of_view_deg", field},
            {"window_hu", window}, {"level_hu", level}};
}

Json example() {
    return {{"what", "pliant keyframes"},
            {"version", 1},
            {"keyframes",
             {frame(0, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}, 80, -500, 1500, -200),
              frame(1.5, {10, 4, -3}, {1, 0, 0}, {0, 0, 1}, 90, -450, 1500, -200),
              frame(2, {12, 9, -8}, {0, -0.6, -0.8}, {0, -0.8, 0.6}, 60, -450, 400, 50),
              frame(4, {-5, 9, -20}, {-1, 0, 0}, {0, 1, 0}, 80, -600, 1000, 0)}}};
}

class Keyframes : public ::testing::Test {
  protected:
    Result<std::vector<app::Keyframe>> read(const std::string& text) {
        const std::string file = (m_folder / "k.json").string();
        std::ofstream(file) << text;
        return app::read_keyframes(file);
    }
    TemporaryFolder m_folder;
};

TEST_F(Keyframes, GiveTheCamerasThatThePageGives) {
    // Values of viewer/src/maths/keyframes.ts for the same file.
    const std::vector<app::Keyframe> page = {
        {0.7,
         {4.782814815, 1.547259259, -1.051555556},
         {0.669130606, 0.743144825, 0},
         {0, 0, 1},
         84.666666667,
         -476.666666667,
         1500,
         -200},
        {1.5, {10, 4, -3}, {1, 0, 0}, {0, 0, 1}, 90, -450, 1500, -200},
        {1.9,
         {12.272, 8.424, -7.1088},
         {0.293729871, -0.665695422, -0.685982775},
         {0.120966672, -0.685982775, 0.717491948},
         66,
         -450,
         620,
         0},
        {2.25,
         {10.353515625, 9.3828125, -9.653125},
         {-0.102248937, -0.756937350, -0.645438613},
         {-0.218286712, -0.615951913, 0.756937350},
         62.5,
         -468.75,
         475,
         43.75},
        {3.6,
         {-1.44, 9.128, -17.6512},
         {-0.925619601, -0.375052322, 0.050637042},
         {-0.330424082, 0.866115282, 0.375052322},
         76,
         -570,
         880,
         10},
    };
    const auto frames = read(example().dump());
    ASSERT_TRUE(frames.ok()) << frames.error().message;
    for (const app::Keyframe& expected : page) {
        SCOPED_TRACE(expected.seconds);
        const app::Keyframe found = app::shot_at(*frames, expected.seconds);
        EXPECT_LT(norm(found.eye_mm - expected.eye_mm), 1e-8);
        EXPECT_LT(norm(found.look - expected.look), 1e-8);
        EXPECT_LT(norm(found.up - expected.up), 1e-8);
        EXPECT_NEAR(found.field_of_view_deg, expected.field_of_view_deg, 1e-8);
        EXPECT_NEAR(found.iso_hu, expected.iso_hu, 1e-8);
        EXPECT_NEAR(found.window_hu, expected.window_hu, 1e-8);
        EXPECT_NEAR(found.level_hu, expected.level_hu, 1e-8);
    }
    EXPECT_EQ(app::shot_at(*frames, -1).eye_mm, (Vec3d{0, 0, 0}));
    EXPECT_EQ(app::shot_at(*frames, 99).eye_mm, (Vec3d{-5, 9, -20}));
}

TEST_F(Keyframes, ThatAreWrongAreRefusedWithTheField) {
    const auto spoilt = [&](const std::string& pointer, const Json& value) {
        Json file = example();
        file[Json::json_pointer(pointer)] = value;
        const auto frames = read(file.dump());
        return frames ? std::string("read") : frames.error().message;
    };
    const struct {
        const char* pointer;
        Json value;
        const char* named;
    } cases[] = {
        {"/what", "something", "what: expected"},
        {"/version", 2, "version: expected 1"},
        {"/keyframes", Json::array(), "keyframes: expected a list"},
        {"/keyframes/0/seconds", 1, "keyframes[0].seconds: expected 0"},
        {"/keyframes/2/seconds", 1.5, "keyframes[2].seconds: expected more than before"},
        {"/keyframes/1/eye_mm", {1, 2}, "keyframes[1].eye_mm: expected three numbers"},
        {"/keyframes/1/look", {0, 0, 0}, "keyframes[1].look: expected a direction"},
        {"/keyframes/3/iso_hu", "low", "keyframes[3].iso_hu: expected a number"},
        {"/keyframes/3", nullptr, "keyframes[3].seconds: expected a number"},
        {"/keyframes/3/field_of_view_deg", 180, "keyframes[3].field_of_view_deg"},
    };
    for (const auto& c : cases)
        EXPECT_NE(spoilt(c.pointer, c.value).find(c.named), std::string::npos)
            << spoilt(c.pointer, c.value);
    EXPECT_FALSE(read("{"));
    EXPECT_EQ(app::read_keyframes("none.json").error().code, ErrorCode::NotFound);
}

}  // namespace
}  // namespace pliant::test
