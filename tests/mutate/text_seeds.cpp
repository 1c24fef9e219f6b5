// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Seeds: ways and cameras of the endoscope, recordings of a device, settings and
// measurements of a fit, networks.

#include "mutate/formats.h"

namespace pliant::mutate {
namespace {

const std::string kKeyframes =
    R"({"what": "pliant keyframes", "version": 1, "keyframes": [
{"seconds": 0, "eye_mm": [0, 0, 0], "look": [0, 1, 0], "up": [0, 0, 1], "field_of_view_deg": 80,
 "iso_hu": -500, "window_hu": 1500, "level_hu": -200},
{"seconds": 0.1, "eye_mm": [5, 9, 1], "look": [1, 1, 0], "up": [0, 0.1, 1], "field_of_view_deg": 60,
 "iso_hu": -400, "window_hu": 1200, "level_hu": -100}]}
)";

const std::string kMarkups =
    R"({"@schema": "https://example.org/markups-schema-v1.0.3.json#", "markups": [
{"type": "Curve", "coordinateSystem": "LPS", "coordinateUnits": "mm", "controlPoints": [
{"id": "1", "position": [-20, -20, 0], "positionStatus": "defined"},
{"id": "2", "position": [20, 20.5, 0], "positionStatus": "defined"},
{"id": "3", "position": [20, 22, 3.0]}]}]}
)";

const std::string kRecording =
    "# pliant haptics: time_ns x y z [mm] roll [rad], of the device\n"
    "1000000 0 0 0 0\n2000000 1 -2.5 3 0.1\n3000000 2 -2.5 -3 0.2\n";

const std::string kFit =
    "size = \"3,3,3\"\nspacing = \"10\"\nyoung = 6e5\npoisson = 0.45\ndensity = 1040\n"
    "groups = \"kinds\"\nvolume = true\nheld = \"-z\"\n"
    "load = [\"+z:0,0,-40:0.2,0.3\"]\nheld-out = [\"+z:0,0,-40\"]\n"
    "method = [\"closed-form\", \"gauss-newton\"]\nevaluations = 10\n";

const std::string kNetwork =
    R"({"format": "pliant spring network", "version": 1, "mesh": "t.vtu",
"groups": [{"name": "links", "value": 4000, "unit": "Pa", "low": 3900, "high": 4100}],
"nodes": {"position_mm": [[-30,-30,-30],[30,-30,-30],[-30,30,-30],[-30,-30,30],[30,30,30]],
"mass_g": [9,9,9,9,9], "damping_g_s": [0,9,9,9,9], "fixed": [0,2], "group": [-1,-1,-1,-1,-1]},
"links": {"nodes": [[0,1],[0,2],[0,3],[1,2],[1,3],[2,3],[1,4],[2,4],[3,4]],
"stiffness_mn_m": [4e4,4e4,4e4,4e4,4e4,4e4,4e4,4e4,4e4], "damping_g_s": [0,0,0,0,0,0,0,0,0],
"rest_length_mm": [60,60,60,84.9,84.9,84.9,84.9,84.9,84.9], "group": [0,0,0,0,0,0,0,0,-1]},
"cells": {"nodes": [[0,1,2,3],[1,4,2,3]], "bulk_pa": [9e3,0], "group": [0,-1]}}
)";

const std::string kTetrahedra =
    "# vtk DataFile Version 3.0\ntwo\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n"
    "-30 -30 -30 30 -30 -30 -30 30 -30 -30 -30 30 30 30 30\nCELLS 2 10\n4 0 1 2 3\n"
    "4 1 4 2 3\nCELL_TYPES 2\n10\n10\n";
const std::string kMeasured = "node,dx,dy,dz\n3,0.25,-0.5,-1.5\n4,0.1,0.2,-0.75\n1,0,0,0\n";
const std::string kMarkers = "# x,y,z,dx,dy,dz\n-30;-30;30;0.25;-0.5;-1.5\n0,0,0,0.1,0.2,-0.75\n";
const std::string kCreep =
    "time_s,node,dx,dy,dz\n0.01,3,0.1,0,-0.5\n0.02,3,0.2,0,-0.9\n0.05,4,0.2,0.1,-0.7\n";

const Words kJsonWords = {"\"position\": ",
                          "\"positionStatus\": \"undefined\"",
                          "\"coordinateSystem\": \"RAS\"",
                          "null",
                          "\"type\": \"ClosedCurve\"",
                          "\"controlPoints\": []",
                          "[]",
                          "{}",
                          "true",
                          "\"\"",
                          "[1, 2]",
                          "[1, 2, 3, 4]",
                          "\"seconds\": ",
                          "\"eye_mm\": ",
                          "\"look\": [0, 0, 0]",
                          "\"field_of_view_deg\": ",
                          "\"version\": 2",
                          "\\u0000",
                          "\\ud800",
                          "\"\xff\"",
                          "1e400",
                          "//",
                          ",",
                          "\"coordinateUnits\": [\"mm\"]"};

Files with_scan(const Sources& from, const std::string& name, const std::string& text) {
    return {{.name = "c.nrrd", .bytes = cube(from, "8"), .fixed = true},
            {.name = name, .bytes = text}};
}

}  // namespace

Format markups(const Sources& from) {
    Seed seed{
        .name = "curve",
        .files = with_scan(from, "w.mrk.json", kMarkups),
        .commands = {"render c.nrrd --path w.mrk.json --speed 200 --view endoscope --size 16x16 "
                     "--threads 1 --movie frames/"}};
    return {
        .name = "markups", .words = kJsonWords, .seeds = {std::move(seed)}, .may_be_long = true};
}

Format keyframes(const Sources& from) {
    Seed seed{
        .name = "two",
        .files = with_scan(from, "k.json", kKeyframes),
        .commands = {"render c.nrrd --keyframes k.json --view endoscope --size 16x16 --threads 1 "
                     "--movie frames/"}};
    return {
        .name = "keyframes", .words = kJsonWords, .seeds = {std::move(seed)}, .may_be_long = true};
}

Format network(const Sources& from) {
    Seed seed{.name = "two",
              .files = with_scan(from, "n.json", kNetwork),
              .commands = {"deform c.nrrd --model springs --network n.json --push 0,0,0:0,6,0 "
                           "--tool sphere:20 --steps 20 --threads 1 --out out.nrrd --report "
                           "r.json"}};
    return {.name = "network", .words = kJsonWords, .seeds = {std::move(seed)}};
}

Format measured(const Sources&) {
    const std::string fit =
        "fit --mesh m.vtk --hold=-31,-31,-31:31,31,-29 --load=-31,-31,29:31,31,31:0,0,-1 "
        "--method gauss-newton --threads 1 --report r.json ";
    const auto seed = [&](const std::string& name, const std::string& text,
                          const std::string& option) {
        return Seed{.name = name,
                    .files = {{.name = "m.vtk", .bytes = kTetrahedra, .fixed = true},
                              {.name = "t.csv", .bytes = text}},
                    .commands = {fit + option}};
    };
    return {.name = "measured",
            .words = {",", ";", "#", "node,", "nan", "inf", "-", "1e300", "1e-300", "0.1,", "\n\n"},
            .seeds = {seed("nodes", kMeasured, "--target t.csv --noise-mm 0.1"),
                      seed("markers", kMarkers, "--target t.csv"),
                      seed("creep", kCreep, "--creep t.csv --noise-mm 0.1")}};
}

Format recording(const Sources&) {
    Seed seed{.name = "places",
              .files = {{.name = "d.txt", .bytes = kRecording}},
              .commands = {"haptics check --device replay:d.txt --minutes 0.001 --threads 1 --out "
                           "r.json --record again.txt"}};
    return {.name = "recording", .words = {"# ", "0 0 0 0\n", "1 2 3"}, .seeds = {std::move(seed)}};
}

Format fit(const Sources&) {
    Seed seed{.name = "box",
              .files = {{.name = "f.toml", .bytes = kFit}},
              .commands = {"fit f.toml --threads 1 --report r.json"}};
    return {.name = "fit",
            .words = {"size = ",
                      "spacing = ",
                      "young = ",
                      "poisson = ",
                      "density = ",
                      "element = ",
                      "held = ",
                      "load = ",
                      "held-out = ",
                      "links = ",
                      "groups = ",
                      "volume = ",
                      "by-cells = true\n",
                      "damping = ",
                      "motion = \"equilibrium\"\n",
                      "motion = \"run\"\n",
                      "duration = ",
                      "depth = ",
                      "cost = ",
                      "range = ",
                      "method = [\"annealing\"]\n",
                      "evaluations = ",
                      "seed = ",
                      "temperature = ",
                      "cooling = ",
                      "report = ",
                      "threads = ",
                      "\"4,4,4\"",
                      "\"1,1,1\"",
                      "[",
                      "]",
                      "\"+x:0,0,1\"",
                      "[section]\n",
                      "\"\"\"",
                      "config = ",
                      "help = true\n"},
            .seeds = {std::move(seed)},
            .may_be_long = true};
}

}  // namespace pliant::mutate
