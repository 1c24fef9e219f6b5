// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The command line. What fit takes is in a file of its own, as it comes from files, too.

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>
#include <map>
#include <string_view>
#include <utility>

#include "fit_options.h"

namespace pliant::app {
namespace {

/// Numbers separated by a character, whatever the locale.
std::vector<double> parse_numbers(std::string_view text, char separator, std::size_t count,
                                  const std::string& option) {
    std::vector<double> numbers;
    const auto fail = [&] {
        throw CLI::ValidationError(option, "expected " + std::to_string(count) +
                                               " numbers separated by '" + separator +
                                               "', found '" + std::string(text) + "'");
    };
    const char* at = text.data();
    const char* const end = at + text.size();
    for (;;) {
        while (at != end && *at == ' ') ++at;
        if (at != end && *at == '+') ++at;
        double number = 0;
        const auto [next, error] = std::from_chars(at, end, number);
        if (error != std::errc{} || !std::isfinite(number)) fail();
        numbers.push_back(number);
        at = next;
        while (at != end && *at == ' ') ++at;
        if (at == end) break;
        if (*at++ != separator) fail();
    }
    if (numbers.size() != count) fail();
    return numbers;
}

Vec3d parse_vector(std::string_view text, const std::string& option) {
    const auto n = parse_numbers(text, ',', 3, option);
    return {n[0], n[1], n[2]};
}

CLI::Option* add_vector(CLI::App* command, const std::string& name, std::optional<Vec3d>& target,
                        const std::string& help) {
    return command
        ->add_option_function<std::string>(
            name, [&target, name](const std::string& text) { target = parse_vector(text, name); },
            help)
        ->type_name("X,Y,Z");
}

void add_series(CLI::App* command, std::string& series) {
    command->add_option("--series", series, "DICOM series UID, where a folder has several");
}

void add_threads(CLI::App* command, int& threads) {
    command->add_option("--threads", threads, "threads to use; 0: all")->check(CLI::Range(0, 256));
}

void add_info(CLI::App& app, InfoOptions& o) {
    auto* c = app.add_subcommand("info", "Show what a scan holds");
    c->add_option("FILE", o.file, "NRRD, MetaImage, NIfTI or DICOM folder")->required();
    add_series(c, o.series);
    c->add_flag("--suggest-push", o.suggest_push, "a place on a wall that gives way");
    c->add_flag("--json", o.json, "one JSON object");
    c->footer("Example:\n  pliant info scan.nrrd --suggest-push");
}

void add_phantom(CLI::App& app, PhantomOptions& o) {
    auto* c = app.add_subcommand("phantom", "Make a test scan from analytic shapes");
    c->add_option("NAME", o.name, "cube, layers, airway, sinus, vessel or knee")->required();
    c->add_option("--out", o.out, "NRRD file to write")->required();
    c->add_option_function<std::string>(
         "--size",
         [&o](const std::string& text) {
             const bool one = text.find('x') == std::string::npos;
             const auto n = parse_numbers(text, 'x', one ? 1 : 3, "--size");
             for (double v : n)
                 if (v != std::floor(v) || v < 2 || v > 4096)
                     throw CLI::ValidationError(
                         "--size", "expected whole numbers 2…4096, found '" + text + "'");
             o.size = one ? Vec3i{int(n[0]), int(n[0]), int(n[0])}
                          : Vec3i{int(n[0]), int(n[1]), int(n[2])};
         },
         "voxels: N, or NxNxN (default 128)")
        ->type_name("N");
    c->add_option_function<std::string>(
         "--spacing",
         [&o](const std::string& text) {
             const bool one = text.find(',') == std::string::npos;
             const auto n = parse_numbers(text, ',', one ? 1 : 3, "--spacing");
             for (double v : n)
                 if (!(v > 0))
                     throw CLI::ValidationError("--spacing",
                                                "expected millimetres > 0, found '" + text + "'");
             o.spacing_mm = one ? Vec3d{n[0], n[0], n[0]} : Vec3d{n[0], n[1], n[2]};
         },
         "mm: one number, or X,Y,Z (default: the phantom's extent / size)")
        ->type_name("MM");
    c->add_option("--direction", o.direction, "nine numbers: the i, j, k axes in LPS");
    c->add_flag("--raw", o.raw, "no compression");
    add_threads(c, o.threads);
    c->footer("Example:\n  pliant phantom airway --size 192 --out airway.nrrd");
}

/// @returns the parts before and after the one colon
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

/// Points separated by semicolons.
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
    const auto [places, radius] = halves_of(text, "--carve", expected);
    const std::vector<Vec3d> points = parse_points(places, "--carve");
    const double radius_mm = parse_numbers(radius, ',', 1, "--carve")[0];
    if (points.size() > 2 || !(radius_mm > 0))
        throw CLI::ValidationError("--carve", "expected " + expected + ", found '" + text + "'");
    return {.from_mm = points.front(), .to_mm = points.back(), .radius_mm = radius_mm};
}

/// Options whose order among each other counts. CLI11 hands over one option at a time, so the texts
/// are taken in the order in which they were parsed.
void add_actions(CLI::App* command, DeformOptions& o) {
    using Parse = DeformAction (*)(const std::string&);
    const auto add = [&](const char* name, const char* type, const std::string& help) {
        return command->add_option(name, help)
            ->type_name(type)
            ->expected(1)
            ->allow_extra_args(false)
            ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    };
    const std::vector<std::pair<CLI::Option*, Parse>> kinds = {
        {add("--push", "X,Y,Z:DX,DY,DZ", "where, and how far, in LPS mm; may be given again"),
         [](const std::string& text) -> DeformAction { return parse_push(text); }},
        {add("--slide", "X,Y,Z:DX,DY,DZ",
             "leads the sphere of --tool along, and tissue slides off it; may be given again"),
         [](const std::string& text) -> DeformAction { return parse_slide(text); }},
        {add("--cut", "X,Y,Z;X,Y,Z[;...]:DX,DY,DZ",
             "a line swept along a vector cuts the links that it crosses; may be given again"),
         [](const std::string& text) -> DeformAction { return parse_cut(text); }},
        {add("--carve", "X,Y,Z[;X,Y,Z]:R",
             "a sphere, or one that moves from place to place, takes out the tissue in it; may be "
             "given again"),
         [](const std::string& text) -> DeformAction { return parse_carve(text); }},
    };
    command->add_option("--load-state", o.load_state, "start from a saved state (.plst)");
    command->add_option("--save-state", o.save_state,
                        "lattice and settings, to go on from (.plst)");
    command->callback([command, kinds, &o] {
        std::map<const CLI::Option*, std::size_t> taken;
        for (const CLI::Option* parsed : command->parse_order())
            for (const auto& [option, parse] : kinds)
                if (option == parsed)
                    o.actions.push_back(parse(parsed->results()[taken[parsed]++]));
        if (o.actions.empty() && o.load_state.empty())
            throw CLI::ValidationError(
                "deform",
                "expected one or more of --push, --slide, --cut, --carve or --load-state");
    });
}

/// Two corners of a box; they may be given in any order.
std::pair<Vec3d, Vec3d> parse_region(const std::string& text) {
    const auto [one, other] = halves_of(text, "--region", "X,Y,Z:X,Y,Z in LPS mm");
    return {parse_vector(one, "--region"), parse_vector(other, "--region")};
}

void add_springs(CLI::App* c, DeformOptions& o) {
    const auto group = "With --model springs";
    c->add_option("--model", o.model, "chainmail, or springs: a mass-spring control lattice")
        ->check(CLI::IsMember({"chainmail", "springs"}));
    c->add_option("--cell-mm", o.springs.cell_mm, "edge of a control cell (default 8)")
        ->type_name("MM")
        ->group(group);
    c->add_option_function<std::string>(
         "--region", [&o](const std::string& text) { o.springs.region_mm = parse_region(text); },
         "opposite corners of what may move, in LPS mm (default: the scan)")
        ->type_name("X,Y,Z:X,Y,Z")
        ->group(group);
    c->add_option("--young-pa", o.springs.young_modulus_pa,
                  "Young's modulus of tissue (default 15000); air has a hundredth of it")
        ->type_name("PA")
        ->group(group);
    c->add_option("--fixed-hu", o.springs.fixed_hu,
                  "nodes with a larger mean value around them don't move (default 300)")
        ->type_name("HU")
        ->group(group);
    c->add_option("--depth", o.springs.depth, "layers of nodes that forces reach (default 10)")
        ->type_name("N")
        ->group(group);
    c->add_option("--steps", o.springs.steps,
                  "time steps after the pushes (default: until it is at rest)")
        ->check(CLI::NonNegativeNumber)
        ->type_name("N")
        ->group(group);
}

void add_deform(CLI::App& app, DeformOptions& o) {
    auto* c = app.add_subcommand("deform", "Push the tissue of a scan and write the deformed scan");
    c->add_option("FILE", o.file, "NRRD, MetaImage, NIfTI or DICOM folder")->required();
    add_series(c, o.series);
    add_actions(c, o);
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
         "point (the eight elements around it) or sphere:R_MM (default point)")
        ->type_name("point|sphere:R_MM");
    add_springs(c, o);
    c->add_option("--config", o.config, "settings, TOML, or key=value lines as of Divod");
    c->add_option("--labels", o.labels, "label map on the scan's grid, for [[label]] settings");
    c->add_option("--directions", o.directions,
                  "vector field (NRRD, LPS) on the scan's grid, for frame = \"direction\"");
    c->add_option("--relax", o.relax_ms, "let the tissue relax for so many milliseconds at most")
        ->check(CLI::NonNegativeNumber)
        ->type_name("MS");
    c->add_option("--relax-sweeps", o.relax_sweeps, "likewise, so many sweeps at most")
        ->check(CLI::NonNegativeNumber)
        ->type_name("N");
    c->add_flag("--release", o.release, "relax without the tool; else what it holds stays");
    c->add_option("--out", o.out, "deformed scan (.nrrd or .nhdr; .vti for ParaView)")->required();
    c->add_option("--displacement", o.displacement, "forward displacement field (NRRD, LPS mm)");
    c->add_option("--transform", o.transform, "inverse: a grid transform of 3D Slicer (NRRD)");
    c->add_option("--jacobian", o.jacobian, "growth of the tissue's volume, 1: none (NRRD)");
    c->add_option("--strain", o.strain, "largest principal Green-Lagrange strain (NRRD)");
    c->add_option("--report", o.report, "what happened, JSON");
    c->add_option("--png", o.png, "before and after, four views each");
    add_vector(c, "--eye", o.eye_mm, "of the picture's endoscope (default: chosen in the lumen)");
    add_vector(c, "--look", o.look, "of the picture's endoscope (default: towards the push)");
    c->add_option("--iso", o.iso_hu, "of the picture's surface [HU] (default -500)");
    c->add_option("--solver", o.solver, "sweep, or heap (the ordered reference)")
        ->check(CLI::IsMember({"sweep", "heap"}));
    c->add_option("--mapping", o.mapping, "cells, or tetrahedra (the twelve of Divod)")
        ->check(CLI::IsMember({"cells", "tetrahedra"}));
    c->add_flag("--raw", o.raw, "no compression");
    add_threads(c, o.threads);
    c->footer(
        "Pushes, slides, cuts and carvings are done in the order in which they are given.\n"
        "Examples:\n"
        "  pliant deform scan.nrrd --push \"-13.5,116,-421:6,0,0\" --tool sphere:4 "
        "--out pushed.nrrd --png pushed.png\n"
        "  pliant deform scan.nrrd --cut \"-30,100,-421;-5,105,-421:0,0,40\" "
        "--push \"-13.5,116,-421:6,0,0\" --out cut.nrrd --save-state cut.plst\n"
        "  pliant deform scan.nrrd --slide \"-20,116,-421:9,0,0\" --tool sphere:4 "
        "--out slid.nrrd\n"
        "  pliant deform scan.nrrd --load-state cut.plst --carve \"-13.5,116,-421:5\" "
        "--out carved.nrrd\n"
        "  pliant deform scan.nrrd --model springs --cell-mm 9 --depth 8 "
        "--push \"-13.5,116,-421:6,0,0\" --out springs.nrrd");
}

void add_render(CLI::App& app, RenderOptions& o) {
    auto* c = app.add_subcommand("render", "Draw the endoscope's view and the sections");
    c->add_option("FILE", o.file, "NRRD, MetaImage, NIfTI or DICOM folder")->required();
    add_series(c, o.series);
    c->add_option("--out", o.out, "PNG file to write");
    c->add_option("--path", o.path, "curve of 3D Slicer (.mrk.json) to fly along");
    c->add_option("--keyframes", o.keyframes, "cameras that the page saved (.json), for a movie");
    c->add_option("--movie", o.movie, "file of the flight (.mp4, made by ffmpeg), or folder/");
    c->add_option("--speed", o.speed_mm_s, "of the flight [mm/s] (default 20)")
        ->check(CLI::Range(0.1, 1000.0));
    c->add_option("--view", o.view,
                  "four-up, endoscope, blended, fluoroscopy, axial, coronal or sagittal")
        ->check(CLI::IsMember(
            {"four-up", "endoscope", "blended", "fluoroscopy", "axial", "coronal", "sagittal"}));
    c->add_option("--iso", o.iso_hu, "threshold of the surface [HU] (default -500)");
    c->add_option("--polarity", o.polarity, "rising (air lumen) or falling (contrast lumen)")
        ->check(CLI::IsMember({"rising", "falling"}));
    add_vector(c, "--eye", o.eye_mm, "of the endoscope, LPS mm (default: chosen in the lumen)");
    add_vector(c, "--look", o.look, "direction (default: along the lumen)");
    add_vector(c, "--up", o.up, "direction that is up in the picture");
    add_vector(c, "--at", o.at_mm,
               "point of the sections, or fluoroscopy's middle, LPS mm (default: eye, scan)");
    c->add_option_function<std::string>(
         "--size",
         [&o](const std::string& text) {
             const auto n = parse_numbers(text, 'x', 2, "--size");
             for (double v : n)
                 if (v != std::floor(v) || v < 16 || v > 8192)
                     throw CLI::ValidationError("--size",
                                                "expected WxH with 16…8192, found '" + text + "'");
             o.width = int(n[0]);
             o.height = int(n[1]);
         },
         "pixels (default 1024x1024 for four-up, 512x512 for one view)")
        ->type_name("WxH");
    c->add_option("--fov", o.field_of_view_deg, "field of view [degrees] (default 80)")
        ->check(CLI::Range(10.0, 150.0));
    c->add_option("--barrel", o.barrel_distortion, "barrel distortion (default 0.15)")
        ->check(CLI::Range(0.0, 1.0));
    c->add_option("--fog", o.fog_distance_mm, "light falls to 1/e over this [mm]; 0: no fog")
        ->check(CLI::Range(0.0, 1e6));
    c->add_option("--colour,--color", o.colour, "of the surface, R,G,B each 0…255");
    c->add_option("--window", o.window_hu, "of the sections [HU] (default 1500; blended: 500)")
        ->check(CLI::PositiveNumber);
    c->add_option("--level", o.level_hu, "of the sections [HU] (default -200; blended: 150)");
    c->add_option("--opacity", o.opacity_per_mm, "blended: at the window's upper end [1/mm]")
        ->check(CLI::Range(0.0, 1000.0));
    c->add_option("--source", o.source_mm, "fluoroscopy: from the source to --at [mm] (1000)")
        ->check(CLI::Range(10.0, 1e6));
    c->add_option("--width", o.width_mm, "fluoroscopy: that is shown at --at [mm] (all)")
        ->check(CLI::Range(1.0, 1e5));
    c->add_option("--exposure", o.exposure_water_mm,
                  "fluoroscopy: water that is mid-grey [mm] (as the picture needs)")
        ->check(CLI::Range(0.0, 1e5));
    c->add_option("--contrast", o.contrast, "fluoroscopy: factor of the absorption (1)")
        ->check(CLI::Range(0.01, 100.0));
    add_threads(c, o.threads);
    c->footer(
        "Example:\n  pliant render scan.nrrd --eye -13.5,116,-411 --look 0,0.7,-0.7 "
        "--out view.png");
}

void add_path(CLI::App& app, PathOptions& o) {
    auto* c = app.add_subcommand("path", "Find the way through a lumen, along its middle");
    c->add_option("FILE", o.file, "NRRD, MetaImage, NIfTI or DICOM folder")->required();
    add_series(c, o.series);
    const auto add_place = [&](const std::string& name, Vec3d& target, const std::string& help) {
        c->add_option_function<std::string>(
             name, [&target, name](const std::string& text) { target = parse_vector(text, name); },
             help)
            ->type_name("X,Y,Z")
            ->required();
    };
    add_place("--from", o.from_mm, "where the way begins, LPS mm");
    add_place("--to", o.to_mm, "where it ends, LPS mm");
    c->add_option("--out", o.out, "curve for 3D Slicer to write (.mrk.json)")->required();
    c->add_option("--iso", o.iso_hu, "threshold of the wall [HU] (default -500)")
        ->check(CLI::Range(-32768.0, 32767.0));
    c->add_option("--polarity", o.polarity, "rising (air lumen) or falling (contrast lumen)")
        ->check(CLI::IsMember({"rising", "falling"}));
    c->add_option("--reach", o.reach_mm, "an end in the tissue moves so far into a lumen [mm]")
        ->check(CLI::Range(0.0, 100.0));
    c->add_option("--spacing", o.spacing_mm, "between points, at most [mm] (default 2)")
        ->check(CLI::Range(0.05, 100.0));
    c->add_flag("--json", o.json, "say length and radii as one JSON object");
    add_threads(c, o.threads);
    c->footer(
        "Examples:\n"
        "  pliant path scan.nrrd --from=-13.5,116,-411 --to=32,202,-578 --out way.mrk.json\n"
        "  pliant render scan.nrrd --view endoscope --path way.mrk.json --movie flight.mp4\n"
        "  pliant path angio.nrrd --from=-6,-31,1180 --to=4,-22,1090 --iso 150 "
        "--polarity falling --reach 5 --out vessel.mrk.json");
}

void add_mesh(CLI::App& app, MeshOptions& o) {
    auto* c = app.add_subcommand(
        "mesh", "Make a vessel's wall of tetrahedra, or judge a mesh (docs/mesh.md)");
    c->add_option("FILE", o.file,
                  "scan or label volume; surface or centreline (VTP, VTU, VTK, MSH, STL, OBJ, PLY)")
        ->required();
    add_series(c, o.series);
    auto* out = c->add_option("--out", o.out, "wall to write (.vtu); else FILE is only judged");
    c->add_option("--ghost", o.ghost, "its inner surface (.vtp, .stl, .obj, .ply)")->needs(out);
    c->add_option("--surface", o.surface, "the lumen's surface, of a scan (.vtp, .stl, .obj, .ply)")
        ->needs(out);
    c->add_option("--thickness", o.thickness_mm, "of the wall [mm] (default 1.5)")
        ->check(CLI::Range(0.01, 100.0));
    c->add_option("--layers", o.layers, "tetrahedra across it, at least (default 2)")
        ->check(CLI::Range(1, 16));
    c->add_option("--cell", o.cell_mm, "of the lattice [mm] (default: what the layers allow)")
        ->check(CLI::Range(0.001, 100.0));
    c->add_option("--ghost-cell", o.ghost_mm,
                  "of a coarser inner surface [mm] (default: the wall's)")
        ->check(CLI::Range(0.001, 100.0));
    c->add_option("--ends", o.ends, "centreline (.vtp) at whose ends a closed surface is cut off");
    c->add_option("--trim", o.trim, "radii that those ends lie inside (default 0.5)")
        ->check(CLI::Range(0.0, 100.0));
    c->add_flag("--sweep", o.sweep, "sweep the wall along a centreline of one branch");
    c->add_option("--sectors", o.sectors, "around a swept wall (default 24)")
        ->check(CLI::Range(3, 4096));
    auto* seed = add_vector(c, "--seed", o.seed_mm, "in a scan's lumen, LPS mm");
    c->add_option_function<std::string>(
         "--window",
         [&o](const std::string& text) {
             const auto n = parse_numbers(text, ',', 2, "--window");
             o.low = n[0];
             o.high = n[1];
         },
         "values of the lumen [HU]")
        ->type_name("LOW,HIGH")
        ->needs(seed);
    add_vector(c, "--to", o.to_mm, "keep to the way through the lumen from the seed to here")
        ->needs(seed);
    c->add_option("--within", o.within_mm, "how far from that way [mm] (default 15)")
        ->check(CLI::Range(0.1, 1000.0));
    c->add_option("--most-ml", o.most_ml,
                  "a larger region leaks, and is refused (default 500; 0: any)")
        ->check(CLI::Range(0.0, 1e6));
    c->add_option("--labels", o.labels, "instead: labels of the lumen, as 1,2")
        ->delimiter(',')
        ->excludes(seed);
    c->add_option("--smooth", o.smoothing_voxels, "the lumen's edge, voxels (default 0.8)")
        ->check(CLI::Range(0.0, 20.0));
    c->add_flag("--json", o.json, "say the mesh's quality as one JSON object");
    add_threads(c, o.threads);
    c->footer(
        "Examples:\n"
        "  pliant mesh centreline.vtp --thickness 1.5 --out wall.vtu --ghost ghost.vtp\n"
        "  pliant mesh surface.vtp --ends centreline.vtp --out wall.vtu\n"
        "  pliant mesh angio.nrrd --seed=-6,-31,1180 --window 150,600 --out wall.vtu\n"
        "  pliant mesh angio.nrrd --seed=-3,-149,545 --to=18,-149,746 --window 250,3500 "
        "--out wall.vtu\n"
        "  pliant mesh labels.nii.gz --labels 1,2 --out wall.vtu\n"
        "  pliant mesh wall.vtu");
}

void add_serve(CLI::App& app, ServeOptions& o) {
    auto* c = app.add_subcommand("serve", "Fly and push in the browser, alone or together");
    c->add_option("FILE", o.file,
                  "NRRD, MetaImage, NIfTI, DICOM folder, or the scene of a vessel, TOML "
                  "(default: the airway phantom)");
    add_series(c, o.series);
    c->add_option_function<int>(
         "--port",
         [&o](int port) {
             o.port = port;
             o.port_given = true;
         },
         "where to listen on this machine; 0: any free one (default 8765, or any free one)")
        ->check(CLI::Range(0, 65535));
    c->add_option("--session", o.session,
                  "record what is done to this file; if it is there, go on where it ended. Scans "
                  "that are opened in the page are kept beside it, in SESSION.scans");
    c->add_option("--checkpoint", o.checkpoint_s,
                  "with a session: save the state beside it after so many seconds of work, so that "
                  "it opens as quickly (default 30)")
        ->check(CLI::Range(0.0, 1e6));
    c->add_flag("--no-open", o.no_open, "print the link, and open no browser");
    c->add_option("--haptics", o.haptics,
                  "a device with force feedback that the page may choose, as pliant haptics check "
                  "--device has it: a plug-in's file with :WHICH, or replay:FILE. May be repeated");
    add_threads(c, o.threads);
    c->footer(
        "Other scans are opened, and the deformed one is saved, in the page.\n"
        "Examples:\n  pliant serve scan.nrrd --session scan.pls\n  pliant serve "
        "scenes/vessel_phantom.toml");
}

void add_replay(CLI::App& app, ReplayOptions& o) {
    auto* c = app.add_subcommand("replay", "Do a recorded session again, and compare the results");
    c->add_option("SESSION", o.session, "file of pliant serve --session")->required();
    c->add_flag(
        "--from-checkpoint", o.from_checkpoint,
        "from the state that was saved last but one, as pliant serve does, not from the start");
    c->add_flag("--json", o.json, "one JSON object");
    add_threads(c, o.threads);
    c->footer("Example:\n  pliant replay scan.pls");
}

void add_bench(CLI::App& app, BenchOptions& o) {
    auto* c = app.add_subcommand("bench", "Compare solvers: time, and how far from exact");
    c->add_option("WHAT", o.what, "chainmail")->required()->check(CLI::IsMember({"chainmail"}));
    c->add_flag("--compare", o.compare, "published orderings beside the exact solvers");
    c->add_flag("--json", o.json, "one JSON object per case and solver, one on each line");
    c->add_option("--size", o.size, "elements along each edge (default 50)")
        ->check(CLI::Range(3, 400));
    c->add_option("--pull", o.pull_voxels, "length of the push [voxels] (default 5)")
        ->check(CLI::Range(0.01, 400.0));
    c->add_option("--grab", o.grab, "element (in the middle of a face), or cell (eight inside)")
        ->check(CLI::IsMember({"element", "cell"}));
    c->add_flag("--homogeneous", o.homogeneous, "only the case of one material");
    c->add_flag("--heterogeneous", o.heterogeneous, "only the case of four materials");
    c->add_option("--shear", o.shear_ratio, "shear / stretch of the four (default 0.5)")
        ->check(CLI::Range(0.0, 2.0));
    c->add_option("--rounds", o.rounds, "how often each is timed, turn by turn (default 9)")
        ->check(CLI::Range(1, 1000));
    c->add_option("--threads", o.threads, "threads of the exact solvers (default 1; 0: all)")
        ->check(CLI::Range(0, 256));
    c->footer("Example:\n  pliant bench chainmail --compare --size 64 --pull 4 --heterogeneous");
}

void add_vessel(CLI::App& app, VesselOptions& o) {
    auto* c = app.add_subcommand("vessel", "Feed a catheter into a vessel, without a window");
    c->add_option("SCENE", o.scene, "vessel, catheter and what the hand does, TOML: docs/vessel.md")
        ->required();
    c->add_option("--report", o.report, "what came of it, JSON");
    c->add_option("--csv", o.csv, "measures of each step");
    c->add_option("--frames", o.frames,
                  "folder for wall, ghost and catheter in time (.vtu, .vtp, .pvd)");
    c->add_option("--every", o.every, "steps from frame to frame (default 50)")
        ->check(CLI::Range(1, 1000000));
    c->add_option("--volume", o.volume,
                  "the scan as the wall carries it at the end (.nrrd, .nhdr, .vti)");
    auto* record = c->add_option("--record", o.record, "log of what the hand did");
    c->add_option("--replay", o.replay, "such a log, instead of the scene's script")
        ->excludes(record);
    c->add_flag("--json", o.json, "print the report instead of a summary");
    add_threads(c, o.threads);
    c->footer(
        "Examples:\n"
        "  pliant vessel scenes/vessel_phantom.toml\n"
        "  pliant vessel aorta.toml --report aorta.json --csv aorta.csv --frames aorta\n"
        "  pliant vessel aorta.toml --record aorta.log && pliant vessel aorta.toml --replay "
        "aorta.log");
}

void add_haptics(CLI::App& app, HapticsOptions& o) {
    auto* c = app.add_subcommand("haptics", "How steady force feedback is on this machine");
    c->add_option("WHAT", o.what, "check, or devices: what is known of some")
        ->required()
        ->check(CLI::IsMember({"check", "devices"}));
    c->add_option("--device", o.device,
                  "virtual[:free|spring|active], replay:FILE, or a plug-in's file "
                  "(default virtual:active)");
    c->add_option("--minutes", o.minutes, "how long (default 10)")->check(CLI::Range(0.001, 1e4));
    c->add_option("--rate", o.rate_hz, "of the servo [Hz] (default 1000)")
        ->check(CLI::Range(500.0, 5000.0));
    c->add_option("--update", o.update_hz, "of the tissue [Hz] (default 30)")
        ->check(CLI::Range(1.0, 1000.0));
    c->add_flag("--load", o.load, "push, resample and draw a phantom at the same time");
    c->add_option("--out", o.out, "report, JSON");
    c->add_option("--record", o.record, "places of the device, for --device replay:FILE");
    c->add_flag("--json", o.json, "say it as one JSON object");
    add_threads(c, o.threads);
    c->footer(
        "Examples:\n"
        "  pliant haptics check --minutes 1\n"
        "  pliant haptics check --load --out servo.json\n"
        "  pliant haptics check --device ./libhaptic_device.so --minutes 0.5\n"
        "  pliant haptics devices");
}

}  // namespace

int bad_input(const std::string& message) {
    std::string line = "pliant: " + message;
    for (char& c : line)
        if (c == '\n' || c == '\r') c = ' ';
    std::fprintf(stderr, "%s\n", line.c_str());
    return kExitBadInput;
}

}  // namespace pliant::app

int main(int argc, char** argv) {
    using namespace pliant::app;
    CLI::App app{"Pliant: soft tissue of medical scans, pushed and seen"};
    app.set_version_flag("--version", PLIANT_VERSION);
    app.require_subcommand(1);
    InfoOptions info;
    PhantomOptions phantom;
    DeformOptions deform;
    RenderOptions render;
    MeshOptions mesh;
    PathOptions path;
    ServeOptions serve;
    ReplayOptions replay;
    BenchOptions bench;
    FitOptions fit;
    HapticsOptions haptics;
    VesselOptions vessel;
    add_info(app, info);
    add_phantom(app, phantom);
    add_deform(app, deform);
    add_render(app, render);
    add_mesh(app, mesh);
    add_path(app, path);
    add_serve(app, serve);
    add_replay(app, replay);
    add_bench(app, bench);
    add_fit(app, fit);
    add_haptics(app, haptics);
    add_vessel(app, vessel);
    const auto named = [&](const CLI::App* command) { return command->get_name() == argv[1]; };
    if (argc > 1 && argv[1][0] != '-' && app.get_subcommands(named).empty())
        return bad_input("unknown command '" + std::string(argv[1]) +
                         "', expected info, phantom, deform, render, mesh, path, serve, replay, "
                         "bench, fit, haptics or vessel");
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& done) {
        return app.exit(done);
    } catch (const CLI::ParseError& error) {
        return bad_input(std::string(error.what()) + " (see pliant --help)");
    }
    if (app.got_subcommand("info")) return run_info(info);
    if (app.got_subcommand("phantom")) return run_phantom(phantom);
    if (app.got_subcommand("deform"))
        return deform.model == "springs" ? run_deform_springs(deform) : run_deform(deform);
    if (app.got_subcommand("mesh")) return run_mesh(mesh);
    if (app.got_subcommand("path")) return run_path(path);
    if (app.got_subcommand("serve")) return run_serve(serve);
    if (app.got_subcommand("replay")) return run_replay(replay);
    if (app.got_subcommand("bench")) return run_bench(bench);
    if (app.got_subcommand("fit")) return run_fit(fit);
    if (app.got_subcommand("haptics")) return run_haptics(haptics);
    if (app.got_subcommand("vessel")) return run_vessel(vessel);
    return run_render(render);
}
