// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Seeds: scenes of `pliant vessel` and logs of the hand.

#include <pliant/mesh_files.h>

#include "mutate/formats.h"
#include "support/temporary_folder.h"

namespace pliant::mutate {
namespace {

const std::string kScene =
    "[vessel]\ncentreline = \"c.vtp\"\nthickness_mm = 1.5\nlayers = 1\ncell_mm = 2\n"
    "[wall]\nyoung_modulus_pa = 5e5\npoisson_ratio = 0.45\nsupport_pa_per_mm = 10000\n"
    "[catheter]\nlength_mm = 60\nbend_n_mm2 = 20\ntip_bend_n_mm2 = 2\ntip_mm = 10\n"
    "[entry]\nplace_mm = [0, 0, 3]\ndirection = [0, 0, 1]\ninserted_mm = 2\n"
    "[way]\nfile = \"c.vtp\"\n"
    "[simulation]\nmost_steps = 20\nbox_mm = 10\n"
    "[[script]]\ninsert_mm_s = 100\nrotate_deg_s = 90\nbend_deg = [30, 10]\nfor_s = 0.003\n"
    "[[script]]\nfollow = true\ninsert_mm_s = -100\nfor_s = 0.002\n";

const Words kSceneWords = {"[vessel]\n",
                           "[wall]\n",
                           "[catheter]\n",
                           "[entry]\n",
                           "[way]\n",
                           "[simulation]\n",
                           "[[script]]\n",
                           "phantom = \"bend\"\n",
                           "surface = ",
                           "scan = ",
                           "label_volume = ",
                           "labels = ",
                           "window_hu = ",
                           "ends = ",
                           "trim = ",
                           "within_mm = ",
                           "thickness_mm = ",
                           "cell_mm = ",
                           "layers = ",
                           "density_g_mm3 = ",
                           "damping_per_s = ",
                           "model = \"tetrahedra\"\n",
                           "length_mm = ",
                           "segment_mm = ",
                           "radius_mm = ",
                           "mass_g_mm = ",
                           "friction = ",
                           "end = ",
                           "inwards = ",
                           "place_mm = ",
                           "direction = ",
                           "points_mm = ",
                           "branch = ",
                           "ahead_mm = ",
                           "gain = ",
                           "reach_mm = -1\n",
                           "time_step_s = ",
                           "sub_steps = ",
                           "iterations = ",
                           "until_way_mm = ",
                           "until_inserted_mm = ",
                           "\"\"\"",
                           "[[[]]]",
                           "{ a = 1 }",
                           "true",
                           "# ",
                           "end 5 ",
                           "pliant vessel log 1\n",
                           "Radius",
                           "NumberOfPoints=\"",
                           "offset=\"",
                           "<Piece>",
                           "NumberOfComponents=\"3\"",
                           "type=\"Float32\"",
                           "format=\"ascii\""};

/// A tube of 20 mm.
std::string centreline() {
    const test::TemporaryFolder folder;
    const std::vector<Vec3d> nodes{{0, 0, 0}, {0, 0, 10}, {0, 1, 20}};
    const std::vector<double> radius{4, 4, 4};
    const std::vector<std::vector<std::int32_t>> lines{{0, 1, 2}};
    (void)write_lines(folder / "c.vtp", nodes, lines, {{}, {{"Radius", radius}}});
    return test::bytes_of(folder / "c.vtp");
}

}  // namespace

Format scene(const Sources&) {
    Seed seed{
        .name = "centreline",
        .files = {{.name = "s.toml", .bytes = kScene}, {.name = "c.vtp", .bytes = centreline()}},
        .commands = {"vessel s.toml --threads 1 --report r.json --csv m.csv",
                     "vessel s.toml --threads 1 --json --frames f --every 4 --record h.log"}};
    return {.name = "scene", .words = kSceneWords, .seeds = {std::move(seed)}, .may_be_long = true};
}

Format hand_log(const Sources& from) {
    Files files{{.name = "s.toml", .bytes = kScene, .fixed = true},
                {.name = "c.vtp", .bytes = centreline(), .fixed = true}};
    const Files made = made_by(from, files, "vessel s.toml --threads 1 --record h.log", {"h.log"});
    files.push_back(made.front());
    Seed seed{.name = "log",
              .files = std::move(files),
              .commands = {"vessel s.toml --replay h.log --threads 1 --report r.json --csv m.csv"}};
    return {
        .name = "hand_log", .words = kSceneWords, .seeds = {std::move(seed)}, .may_be_long = true};
}

}  // namespace pliant::mutate
