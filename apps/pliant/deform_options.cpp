// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Options of `pliant deform`.

#include <pliant/tissues.h>

#include <charconv>
#include <cstdint>
#include <map>
#include <string>
#include <system_error>
#include <utility>

#include "commands.h"
#include "common_options.h"
#include "deform_models.h"
#include "setting_options.h"

namespace pliant::app {
namespace {

constexpr double kDepthWithin_mm = 0.1;

/// @returns parts before and after the only colon
std::pair<std::string, std::string> halves_of(const std::string& text, const std::string& option,
                                              const std::string& expected) {
    const auto colon = text.find(':');
    if (colon == std::string::npos)
        throw CLI::ValidationError(option, "expected " + expected + ", found '" + text + "'");
    return {text.substr(0, colon), text.substr(colon + 1)};
}

PushOption parse_push(const std::string& text) {
    const auto [point, push] = halves_of(text, "--push", "X,Y,Z:DX,DY,DZ in LPS mm");
    return {parse_vector(point, "--push"), parse_vector(push, "--push")};
}

SlideOption parse_slide(const std::string& text) {
    const auto [point, way] = halves_of(text, "--slide", "X,Y,Z:DX,DY,DZ in LPS mm");
    return {parse_vector(point, "--slide"), parse_vector(way, "--slide")};
}

/// Parses points separated by semicolons.
std::vector<Vec3d> parse_points(std::string_view text, const std::string& option) {
    std::vector<Vec3d> points;
    for (;;) {
        const auto semicolon = text.find(';');
        points.push_back(parse_vector(text.substr(0, semicolon), option));
        if (semicolon == std::string_view::npos) return points;
        text.remove_prefix(semicolon + 1);
    }
}

CutSurface parse_cut(const std::string& text) {
    const std::string expected = "X,Y,Z;X,Y,Z[;…]:DX,DY,DZ in LPS mm";
    const auto [line, depth] = halves_of(text, "--cut", expected);
    CutSurface surface{parse_points(line, "--cut"), parse_vector(depth, "--cut")};
    if (surface.line_mm.size() < 2)
        throw CLI::ValidationError("--cut", "expected " + expected + ", found '" + text + "'");
    return surface;
}

CarveTool parse_carve(const std::string& text) {
    const std::string expected = "X,Y,Z[;X,Y,Z]:R in LPS mm";
    const auto [positions, radius] = halves_of(text, "--carve", expected);
    const std::vector<Vec3d> points = parse_points(positions, "--carve");
    const double radius_mm = parse_numbers(radius, ',', 1, "--carve")[0];
    if (points.size() > 2 || !(radius_mm > 0))
        throw CLI::ValidationError("--carve", "expected " + expected + ", found '" + text + "'");
    return {.from_mm = points.front(), .to_mm = points.back(), .radius_mm = radius_mm};
}

/// Adds options whose relative order matters. CLI11 hands over one option at a time, so the texts
/// are taken in the order of parsing.
/// @param carves  whether carvings and states are among them
void add_actions(CLI::App* command, DeformOptions& o, bool carves) {
    using Parse = DeformAction (*)(const std::string&);
    const auto add = [&](const char* name, const char* type, const std::string& help) {
        return command->add_option(name, help)
            ->type_name(type)
            ->expected(1)
            ->allow_extra_args(false)
            ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    };
    std::vector<std::pair<CLI::Option*, Parse>> kinds = {
        {add("--push", "X,Y,Z:DX,DY,DZ", "point and displacement, in LPS mm; repeatable"),
         [](const std::string& text) -> DeformAction { return parse_push(text); }},
        {add("--slide", "X,Y,Z:DX,DY,DZ",
             "moves the sphere of --tool; tissue slides off it; repeatable"),
         [](const std::string& text) -> DeformAction { return parse_slide(text); }},
        {add("--cut", "X,Y,Z;X,Y,Z[;...]:DX,DY,DZ",
             "cuts the tissue across a line swept along a vector; repeatable"),
         [](const std::string& text) -> DeformAction { return parse_cut(text); }},
    };
    if (carves) {
        kinds.emplace_back(
            add("--carve", "X,Y,Z[;X,Y,Z]:R",
                "takes out the tissue in a sphere, or in a capsule; repeatable"),
            [](const std::string& text) -> DeformAction { return parse_carve(text); });
        command->add_option("--load-state", o.load_state, "start from a saved state (.plst)");
        command->add_option("--save-state", o.save_state, "save the tissue's state (.plst)");
    }
    command->callback([command, kinds, carves, &o] {
        std::map<const CLI::Option*, std::size_t> taken;
        for (const CLI::Option* parsed : command->parse_order())
            for (const auto& [option, parse] : kinds)
                if (option == parsed)
                    o.actions.push_back(parse(parsed->results()[taken[parsed]++]));
        if (o.actions.empty() && o.load_state.empty())
            throw CLI::ValidationError(
                command->get_name(),
                carves ? "expected one or more of --push, --slide, --cut, --carve or --load-state"
                       : "expected one or more of --push, --slide and --cut");
    });
}

/// Parses two opposite corners of a box, in any order.
std::pair<Vec3d, Vec3d> parse_region(const std::string& text) {
    const auto [one, other] = halves_of(text, "--region", "X,Y,Z:X,Y,Z in LPS mm");
    return {parse_vector(one, "--region"), parse_vector(other, "--region")};
}

void add_tool(CLI::App* c, DeformOptions& o, const char* help) {
    c->add_option_function<std::string>(
         "--tool",
         [&o](const std::string& text) {
             if (text == "point") {
                 o.sphere_radius_mm = 0;
             } else if (text.starts_with("sphere:")) {
                 o.sphere_radius_mm = parse_numbers(text.substr(7), ',', 1, "--tool sphere")[0];
                 if (!(o.sphere_radius_mm > 0))
                     throw CLI::ValidationError("--tool",
                                                "expected a radius > 0 mm, found '" + text + "'");
             } else {
                 throw CLI::ValidationError("--tool",
                                            "expected point or sphere:R_MM, found '" + text + "'");
             }
         },
         help)
        ->type_name("point|sphere:R_MM");
}

void add_models(CLI::App* c, DeformOptions& o) {
    std::vector<std::string> models;
    for (const DeformModel& model : deform_models()) models.emplace_back(model.name);
    c->add_option("--model", o.model,
                  "chainmail; elastic: finite elements on the voxels, whose moduli are in "
                  "--config; springs: a mass-spring control lattice; body: the tetrahedra of "
                  "--mesh, position-based; rigid: nothing moves")
        ->check(CLI::IsMember(models));
    const auto add = [&](auto rows, const char* name, const char* type, const char* group,
                         const char* other_names = "") {
        add_setting(c, rows, name, o.settings, other_names)->type_name(type)->group(group);
    };
    const char* const both = "With --model springs or body";
    const char* const moving = "With --model elastic, springs or body";
    add(spring_rows(), "young_modulus_pa", "PA", both, ",--young-pa");
    add_setting(c, spring_rows(), "poisson_ratio", o.settings)
        ->description("Poisson's ratio (default " +
                      toml_text(SpringDeformationSettings{}.poisson_ratio) + ", of a body " +
                      toml_text(BodySettings{}.poisson_ratio) + ", of the elastic scan " +
                      toml_text(ElasticScanSettings{}.poisson_ratio) + ")")
        ->type_name("RATIO")
        ->group(moving);
    add(spring_rows(), "fixed_hu", "HU", both);
    c->add_option("--steps", o.steps, "time steps after the pushes (default: until it is at rest)")
        ->check(CLI::NonNegativeNumber)
        ->type_name("N")
        ->group(moving);
    add(elastic_scan_rows(), "held_above_hu", "HU", "With --model elastic");
    const char* const springs = "With --model springs";
    c->add_option_function<std::string>(
         "--region", [&o](const std::string& text) { o.region_mm = parse_region(text); },
         "opposite corners of the movable region, in LPS mm (default: the scan)")
        ->type_name("X,Y,Z:X,Y,Z")
        ->group(springs);
    add(spring_rows(), "cell_mm", "MM", springs);
    c->add_option_function<std::string>(
         "--depth",
         [&o](const std::string& text) {
             if (text == "auto" || text.starts_with("auto:")) {
                 o.depth_within_mm = text == "auto"
                                         ? kDepthWithin_mm
                                         : parse_numbers(text.substr(5), ',', 1, "--depth auto")[0];
                 if (*o.depth_within_mm > 0) return;
                 throw CLI::ValidationError("--depth",
                                            "expected a length above 0 mm, found '" + text + "'");
             }
             int layers = 0;
             const auto [end, error] =
                 std::from_chars(text.data(), text.data() + text.size(), layers);
             if (error != std::errc{} || end != text.data() + text.size())
                 throw CLI::ValidationError(
                     "--depth", "expected layers, or auto, or auto:MM, found '" + text + "'");
             o.settings.emplace_back("depth", SettingValue(std::int64_t(layers)));
         },
         "layers of nodes that forces reach beyond a tool (default 10); auto: the "
         "smallest number for which one more moves nothing by more than MM (default 0.1)")
        ->type_name("N|auto[:MM]")
        ->group(springs);
    c->add_option(
         "--network", o.network,
         "springs of pliant fit --network-out, instead of a lattice: their nodes are in the "
         "scan's LPS mm")
        ->group(springs);
    add(network_rows(), "solve_tolerance", "SHARE", "With --network");
    const char* const body = "With --model body";
    auto* mesh = c->add_option("--mesh", o.mesh, "tetrahedra in the scan's LPS (.vtu, .vtk, .msh)")
                     ->group(body);
    add_units(c, o.units)->needs(mesh)->group(body);
    add(body_rows(), "density_kg_m3", "KG_M3", body);
    add(body_rows(), "damping_per_s", "PER_S", body);
    add(body_rows(), "sub_steps", "N", body);
    const char* const meshes = "With --model body, or springs with --network";
    add(body_rows(), "time_step_s", "S", meshes);
    add(body_rows(), "reach_mm", "MM", meshes);
}

}  // namespace

void add_deform(CLI::App& app, DeformOptions& o) {
    auto* c = app.add_subcommand("deform", "Push the tissue of a scan and write the deformed scan");
    c->add_option("FILE", o.file, "NRRD, MetaImage, NIfTI, VTI, VTK image, DICOM file or folder")
        ->required();
    add_scan(c, o.scan);
    add_actions(c, o, true);
    add_tool(c, o, "point (the eight elements around it) or sphere:R_MM (default point)");
    add_models(c, o);
    c->add_option("--config", o.config, "settings: TOML, or the thesis's key=value format");
    c->add_option(
        "--labels", o.labels,
        "label map, for [[label]] settings and --labels-out; of a file of several layers FILE#0, "
        "FILE#1, …");
    c->add_option("--directions", o.directions,
                  "vector field (NRRD, LPS) on the scan's grid, for frame = \"direction\"");
    // Of older versions; not in --help.
    c->add_option_function<std::string>("--elastic", [](const std::string&) {
         throw CLI::ValidationError("--elastic",
                                    "expected --model elastic, which replaces it, "
                                    "with moduli in [elastic] of --config");
     })->group("");
    c->add_option("--relax", o.relax_ms, "relax the tissue for at most MS milliseconds")
        ->check(CLI::NonNegativeNumber)
        ->type_name("MS");
    c->add_option("--relax-sweeps", o.relax_sweeps, "relax the tissue for at most N sweeps")
        ->check(CLI::NonNegativeNumber)
        ->type_name("N");
    c->add_flag("--release", o.release, "relax without the tool (default: it holds its elements)");
    c->add_option("--out", o.out, "deformed scan (.nrrd, .nhdr, .mha, .mhd, .nii, .nii.gz or .vti)")
        ->required();
    c->add_option("--displacement", o.displacement, "forward displacement field (NRRD, LPS mm)");
    c->add_option("--labels-out", o.labels_out, "deformed --labels, on the scan's grid");
    c->add_option("--transform", o.transform, "inverse: a grid transform of 3D Slicer (NRRD)");
    c->add_option("--jacobian", o.jacobian, "growth of the tissue's volume, 1: none (NRRD)");
    c->add_option("--strain", o.strain, "largest principal Green-Lagrange strain (NRRD)");
    c->add_option("--report", o.report, "report, JSON; -: to standard output");
    add_picture(c, o.picture, "towards the push");
    c->add_option("--solver", o.solver, "sweep, or heap (the ordered reference): limits of a box")
        ->check(CLI::IsMember({"sweep", "heap"}));
    c->add_option("--mapping", o.mapping, "cells, or twelve tetrahedra per cell (reference)")
        ->check(CLI::IsMember({"cells", "tetrahedra"}));
    c->add_flag("--raw", o.raw, "no compression");
    add_threads(c, o.threads);
    c->footer(
        "Pushes, slides, cuts and carvings are done in the order in which they are given.\n"
        "Examples:\n"
        "  pliant deform scan.nrrd --push \"-6.5,130,-437:3,-3,-2\" --tool sphere:4 "
        "--out pushed.nrrd --png pushed.png\n"
        "  pliant deform scan.nrrd --cut \"-3,133,-428;8,124,-435:-12,-8,-7\" "
        "--push \"-6.5,130,-437:3,-3,-2\" --tool sphere:4 --out cut.nrrd --save-state cut.plst\n"
        "  pliant deform scan.nrrd --slide \"-14,138,-437:7,-6,-4\" --tool sphere:4 "
        "--out slid.nrrd\n"
        "  pliant deform scan.nrrd --load-state cut.plst --carve \"-3,127,-438:4\" "
        "--out carved.nrrd\n"
        "  pliant deform scan.nrrd --model elastic --config moduli.toml "
        "--push \"-6.5,130,-437:3,-3,-2\" --tool sphere:4 --out elastic.nrrd --report -\n"
        "  pliant deform scan.nrrd --model springs --cell-mm 9 --depth 8 "
        "--push \"-6.5,130,-437:3,-3,-2\" --out springs.nrrd\n"
        "  pliant deform scan.nrrd --model springs --labels organs.nrrd --config organs.toml "
        "--push \"-6.5,130,-437:3,-3,-2\" --out springs.nrrd\n"
        "  pliant deform scan.nrrd --model body --mesh organ.vtu "
        "--push \"-6.5,130,-437:3,-3,-2\" --tool sphere:8 --out body.nrrd\n"
        "  pliant deform scan.nrrd --model springs --network fit.json "
        "--push \"-6.5,130,-437:3,-3,-2\" --out springs.nrrd");
}

void add_body(CLI::App& app, BodyOptions& options) {
    DeformOptions& o = options.deform;
    o.model = "body";
    o.picture.shows_tool = true;
    auto* c = app.add_subcommand("body", "Push organs: meshes, or the labelled parts of a scan");
    c->add_option(
         "FILE", o.file,
         "an organ (VTU, VTP, VTK, MSH, STL, OBJ, PLY: tetrahedra, or a closed surface), a "
         "scene of organs (TOML: docs/howto/organs.md), or a scan with --labels")
        ->required();
    c->add_option("--labels", options.labels, "label map of the scan: a body of each organ");
    add_label_names(c, options.label_names);
    add_body_labels(c, options.bodies);
    add_units(c, o.units);
    add_scan(c, o.scan);
    add_actions(c, o, false);
    add_tool(c, o, "point (the tetrahedron around it) or sphere:R_MM (default point)");
    c->add_option("--steps", o.steps, "time steps after the pushes (default: until it is at rest)")
        ->check(CLI::NonNegativeNumber)
        ->type_name("N");
    c->add_flag("--release", o.release, "let go before that (default: the tools stay)");
    c->add_option(
        "--out", o.mesh_out,
        "moved tetrahedra, with each node's displacement and each cell's body and, after a "
        "cut, its share of the material (.vtu)");
    c->add_option("--volume", o.out, "deformed scan (.nrrd, .mha, .nii.gz, .vti …)");
    c->add_option("--displacement", o.displacement, "forward displacement field (NRRD, LPS mm)");
    c->add_option("--labels-out", o.labels_out, "deformed --labels, on the scan's grid");
    c->add_option("--transform", o.transform, "inverse: a grid transform of 3D Slicer (NRRD)");
    c->add_option("--report", o.report, "report, JSON; -: to standard output");
    add_picture(c, o.picture, "towards the push");
    c->add_flag("--raw", o.raw, "no compression");
    add_threads(c, o.threads);
    c->footer(
        "Examples:\n"
        "  pliant body liver.vtu --push \"-20,-235,-300:0,12,0\" --tool sphere:12 --out moved.vtu "
        "--report moved.json\n"
        "  pliant body liver.vtk --slide \"20,-270,-300:0,40,0\" --tool sphere:12 --png slid.png\n"
        "  pliant body liver.vtk --cut \"-60,-280,-300;20,-280,-300:0,90,0\" "
        "--push \"-20,-235,-285:0,-10,12\" --tool sphere:12 --png cut.png\n"
        "  pliant body abdomen.nii.gz --labels organs.nii.gz --bodies 5,6 "
        "--push \"41,-235,388:0,10,0\" --tool sphere:12 --volume pushed.nrrd\n"
        "Positions are those of liver_set and of abdomen_ct_3mm (docs/howto/organs.md); "
        "pliant mesh FILE\n"
        "prints the corners of another mesh.");
}

}  // namespace pliant::app
