// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Seeds: scenes of `pliant vessel`, logs of the hand, closed surfaces with a centreline, scans with
// a way through them.

#include <pliant/mesh.h>
#include <pliant/mesh_files.h>

#include <cmath>
#include <numbers>

#include "mutate/formats.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

namespace pliant::mutate {
namespace {

const std::string kScene =
    "[vessel]\ncentreline = \"c.vtp\"\nthickness_mm = 1.5\nlayers = 1\ncell_mm = 2\n"
    "[wall]\nyoung_modulus_pa = 5e5\npoisson_ratio = 0.45\nsupport_pa_per_mm = 10000\n"
    "[catheter]\nlength_mm = 60\nbend_n_mm2 = 20\ntip_bend_n_mm2 = 2\ntip_mm = 10\n"
    "[entry]\nplace_mm = [0, 0, 3]\ndirection = [0, 0, 1]\ninserted_mm = 2\n"
    "[way]\nfile = \"c.vtp\"\n"
    "[simulation]\nmax_steps = 20\nbox_mm = 10\n"
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

const Words kScanWords = {"sizes: ",        "space directions: ",
                          "space origin: ", "(1e-9,0,0)",
                          "(1e9,0,0)",      "(0,0,0)",
                          "(-1,0,0)",       "14 14 1",
                          "1 1 4704",       "encoding: gzip",
                          "type: float",    "nan"};

/// A tube of 20 mm.
std::string centreline() {
    const test::TemporaryFolder folder;
    const std::vector<Vec3d> nodes{{0, 0, 0}, {0, 0, 10}, {0, 1, 20}};
    const std::vector<double> radius{4, 4, 4};
    const std::vector<std::vector<std::int32_t>> lines{{0, 1, 2}};
    (void)write_lines(folder / "c.vtp", nodes, lines, {{}, {{"Radius", radius}}});
    return test::bytes_of(folder / "c.vtp");
}

constexpr double kRadiusMm = 4, kLengthMm = 20;

/// A closed tube along z.
std::string closed_tube() {
    constexpr int kSectors = 12, kRings = 9;
    const test::TemporaryFolder folder;
    TriangleMesh tube{.nodes_mm = {{0, 0, 0}, {0, 0, kLengthMm}}, .cells = {}};
    for (int ring = 0; ring < kRings; ++ring)
        for (int n = 0; n < kSectors; ++n) {
            const double angle = 2 * std::numbers::pi * n / kSectors;
            tube.nodes_mm.push_back({kRadiusMm * std::cos(angle), kRadiusMm * std::sin(angle),
                                     kLengthMm * ring / (kRings - 1)});
        }
    const auto node = [](int ring, int n) { return 2 + ring * kSectors + n % kSectors; };
    for (int n = 0; n < kSectors; ++n) {
        tube.cells.push_back({0, node(0, n + 1), node(0, n)});
        tube.cells.push_back({1, node(kRings - 1, n), node(kRings - 1, n + 1)});
        for (int r = 0; r + 1 < kRings; ++r) {
            tube.cells.push_back({node(r, n), node(r, n + 1), node(r + 1, n + 1)});
            tube.cells.push_back({node(r, n), node(r + 1, n + 1), node(r + 1, n)});
        }
    }
    (void)write_surface(folder / "t.obj", tube);
    return test::bytes_of(folder / "t.obj");
}

/// The same tube with contrast agent, in voxels of a millimetre.
test::NrrdFile contrast_tube() {
    constexpr int kSide = 14, kSlices = 24;
    constexpr double kMiddle = 0.5 * (kSide - 1);
    std::vector<std::int16_t> values;
    for (int k = 0; k < kSlices; ++k)
        for (int j = 0; j < kSide; ++j)
            for (int i = 0; i < kSide; ++i)
                values.push_back(std::hypot(i - kMiddle, j - kMiddle) < kRadiusMm ? 300 : 0);
    return {.sizes = "14 14 24",
            .directions = "(1,0,0) (0,1,0) (0,0,1)",
            .origin = "(-6.5,-6.5,0)",
            .data = test::packed(values)};
}

File scan_file(const test::NrrdFile& scan) {
    const std::string bytes = scan.bytes();
    return {.name = "v.nrrd", .bytes = bytes, .header = bytes.size() - scan.data.size()};
}

const std::string kHand =
    "[catheter]\nlength_mm = 40\n"
    "[entry]\nplace_mm = [0, 0, 5]\ndirection = [0, 0, 1]\ninserted_mm = 2\n"
    "[simulation]\nmax_steps = 20\n[[script]]\ninsert_mm_s = 100\nfor_s = 0.003\n";
const std::string kSurfaceScene =
    "[vessel]\nsurface = \"t.obj\"\nends = \"c.vtp\"\nlayers = 1\ncell_mm = 2\n" + kHand;
const std::string kScanScene =
    "[vessel]\nscan = \"v.nrrd\"\nwindow_hu = [150, 400]\nlayers = 1\ncell_mm = 2\n"
    "[way]\npoints_mm = [[0, 0, 4], [0, 0, 18]]\n" +
    kHand;

}  // namespace

Files vessel_files() {
    return {{.name = "s.toml", .bytes = kScene}, {.name = "c.vtp", .bytes = centreline()}};
}

Format scene(const Sources&) {
    const std::string report = "vessel s.toml --threads 1 --report r.json --csv m.csv";
    Seed line{.name = "centreline",
              .files = vessel_files(),
              .commands = {report,
                           "vessel s.toml --threads 1 --json --frames f --every 4 "
                           "--record h.log"}};
    Seed surface{.name = "surface",
                 .files = {{.name = "s.toml", .bytes = kSurfaceScene},
                           {.name = "t.obj", .bytes = closed_tube()},
                           {.name = "c.vtp", .bytes = centreline()}},
                 .commands = {report}};
    Seed scan{.name = "scan",
              .files = {{.name = "s.toml", .bytes = kScanScene}, scan_file(contrast_tube())},
              .commands = {report, "vessel s.toml --threads 1 --json --volume o.nrrd"}};
    return {.name = "scene",
            .words = kSceneWords,
            .seeds = {std::move(line), std::move(surface), std::move(scan)},
            .may_be_long = true};
}

Format ends(const Sources&) {
    Seed seed{.name = "tube",
              .files = {{.name = "t.obj", .bytes = closed_tube()},
                        {.name = "c.vtp", .bytes = centreline()}},
              .commands = {"mesh t.obj --ends c.vtp --layers 1 --cell 2 --out w.vtu --threads 1",
                           "mesh t.obj --ends c.vtp --trim 1 --out w.vtu --ghost g.ply --json "
                           "--threads 1"}};
    return {.name = "ends", .words = kSceneWords, .seeds = {std::move(seed)}, .may_be_long = true};
}

Format path(const Sources&) {
    const std::string from_to = "path v.nrrd --from=0,0,4 --to=0,0,18 --threads 1 --out w.mrk.json";
    const std::string falling = from_to + " --polarity falling";
    const test::NrrdFile raw = contrast_tube();
    test::NrrdFile gzip = raw;
    gzip.encoding = "gzip";
    gzip.data = test::gzipped(raw.data);
    Format format{.name = "path", .words = kScanWords, .seeds = {}};
    for (const auto& [name, scan] : {std::pair("raw", raw), std::pair("gzip", gzip)})
        format.seeds.push_back(
            {.name = name,
             .files = {scan_file(scan)},
             .commands = {falling + " --iso 150", falling + " --iso 299.5 --spacing 0.05 --json",
                          falling + " --iso 150 --reach 100 --spacing 100",
                          from_to + " --iso 150 --reach 50"}});
    return format;
}

Format hand_log(const Sources& from) {
    Files files = vessel_files();
    for (File& file : files) file.fixed = true;
    const Files made = made_by(from, files, "vessel s.toml --threads 1 --record h.log", {"h.log"});
    files.push_back(made.front());
    Seed seed{.name = "log",
              .files = std::move(files),
              .commands = {"vessel s.toml --replay h.log --threads 1 --report r.json --csv m.csv"}};
    return {
        .name = "hand_log", .words = kSceneWords, .seeds = {std::move(seed)}, .may_be_long = true};
}

}  // namespace pliant::mutate
