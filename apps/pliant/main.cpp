// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The command line: the only place that knows CLI11.

#include "options.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>
#include <string_view>

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
    c->add_option("NAME", o.name, "cube, layers, airway, sinus or vessel")->required();
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

void add_deform(CLI::App& app, DeformOptions& o) {
    auto* c = app.add_subcommand("deform", "Push the tissue of a scan and write the deformed scan");
    c->add_option("FILE", o.file, "NRRD, MetaImage, NIfTI or DICOM folder")->required();
    add_series(c, o.series);
    c->add_option_function<std::vector<std::string>>(
         "--push",
         [&o](const std::vector<std::string>& texts) {
             for (const std::string& text : texts) {
                 const auto colon = text.find(':');
                 if (colon == std::string::npos)
                     throw CLI::ValidationError(
                         "--push", "expected X,Y,Z:DX,DY,DZ in LPS mm, found '" + text + "'");
                 o.pushes.push_back({parse_vector(text.substr(0, colon), "--push"),
                                     parse_vector(text.substr(colon + 1), "--push")});
             }
         },
         "where, and how far, in LPS mm; may be given again, applied in order")
        ->type_name("X,Y,Z:DX,DY,DZ")
        ->allow_extra_args(false)
        ->required();
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
    c->add_option("--config", o.config, "settings, TOML, or key=value lines as of Divod");
    c->add_option("--relax", o.relax_ms, "let the tissue relax for so many milliseconds at most")
        ->check(CLI::NonNegativeNumber)
        ->type_name("MS");
    c->add_option("--relax-sweeps", o.relax_sweeps, "likewise, so many sweeps at most")
        ->check(CLI::NonNegativeNumber)
        ->type_name("N");
    c->add_flag("--release", o.release, "relax without the tool; else what it holds stays");
    c->add_option("--out", o.out, "deformed scan (.nrrd or .nhdr)")->required();
    c->add_option("--displacement", o.displacement, "forward displacement field (NRRD, LPS mm)");
    c->add_option("--transform", o.transform, "inverse: a grid transform of 3D Slicer (NRRD)");
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
        "Example:\n  pliant deform scan.nrrd --push \"-13.5,116,-421:6,0,0\" --tool sphere:4 "
        "--out pushed.nrrd --png pushed.png");
}

void add_render(CLI::App& app, RenderOptions& o) {
    auto* c = app.add_subcommand("render", "Draw the endoscope's view and the sections");
    c->add_option("FILE", o.file, "NRRD, MetaImage, NIfTI or DICOM folder")->required();
    add_series(c, o.series);
    c->add_option("--out", o.out, "PNG file to write")->required();
    c->add_option("--view", o.view, "four-up, endoscope, axial, coronal or sagittal")
        ->check(CLI::IsMember({"four-up", "endoscope", "axial", "coronal", "sagittal"}));
    c->add_option("--iso", o.iso_hu, "threshold of the surface [HU] (default -500)");
    c->add_option("--polarity", o.polarity, "rising (air lumen) or falling (contrast lumen)")
        ->check(CLI::IsMember({"rising", "falling"}));
    add_vector(c, "--eye", o.eye_mm, "of the endoscope, LPS mm (default: chosen in the lumen)");
    add_vector(c, "--look", o.look, "direction (default: along the lumen)");
    add_vector(c, "--up", o.up, "direction that is up in the picture");
    add_vector(c, "--at", o.at_mm, "point of the sections, LPS mm (default: the eye)");
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
    c->add_option("--window", o.window_hu, "of the sections [HU] (default 1500)")
        ->check(CLI::PositiveNumber);
    c->add_option("--level", o.level_hu, "of the sections [HU] (default -200)");
    add_threads(c, o.threads);
    c->footer(
        "Example:\n  pliant render scan.nrrd --eye -13.5,116,-411 --look 0,0.7,-0.7 "
        "--out view.png");
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
    add_info(app, info);
    add_phantom(app, phantom);
    add_deform(app, deform);
    add_render(app, render);
    const auto named = [&](const CLI::App* command) { return command->get_name() == argv[1]; };
    if (argc > 1 && argv[1][0] != '-' && app.get_subcommands(named).empty())
        return bad_input("unknown command '" + std::string(argv[1]) +
                         "', expected info, phantom, deform or render");
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& done) {
        return app.exit(done);
    } catch (const CLI::ParseError& error) {
        return bad_input(std::string(error.what()) + " (see pliant --help)");
    }
    if (app.got_subcommand("info")) return run_info(info);
    if (app.got_subcommand("phantom")) return run_phantom(phantom);
    if (app.got_subcommand("deform")) return run_deform(deform);
    return run_render(render);
}
