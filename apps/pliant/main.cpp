// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The command line.

#include <pliant/core/files.h>
#include <pliant/core/version.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

#include "commands.h"
#include "ending.h"
#include "fit_options.h"
#include "progress.h"

namespace pliant::app {

int bad_input(const std::string& message) {
    const std::string line = one_line(about_targets(message));
    clear_progress_line();
    return say_why(line.c_str());
}

int bad_input(const Error& error) {
    const int status = bad_input(error.message);
    if (error.field == "series") std::fputs(error.expected.c_str(), stderr);
    return status;
}

}  // namespace pliant::app

namespace pliant::app {
namespace {

int run(int argc, char** argv) {
    CLI::App app{"Pliant: soft tissue of medical scans, pushed and seen"};
    app.set_version_flag("--version", PLIANT_VERSION);
    app.require_subcommand(1);
    InfoOptions info;
    ConvertOptions convert;
    PhantomOptions phantom;
    DeformOptions deform;
    BodyOptions body;
    RenderOptions render;
    MeshOptions mesh;
    PathOptions path;
    ServeOptions serve;
    ReplayOptions replay;
    BenchOptions bench;
    FitOptions fit;
    HapticsOptions haptics;
    VesselOptions vessel;
    TruthOptions truth;
    MorphOptions morph;
    MaterialsOptions materials;
    ConformanceOptions conformance;
    add_info(app, info);
    add_convert(app, convert);
    add_phantom(app, phantom);
    add_deform(app, deform);
    add_body(app, body);
    add_render(app, render);
    add_mesh(app, mesh);
    add_path(app, path);
    add_serve(app, serve);
    add_replay(app, replay);
    add_bench(app, bench);
    add_fit(app, fit);
    add_haptics(app, haptics);
    add_vessel(app, vessel);
    add_truth(app, truth);
    add_morph(app, morph);
    add_materials(app, materials);
    add_conformance(app, conformance);
    app.footer("In the Python package there is also pliant study, for thousands of commands.");
    if (argc > 1 && std::string(argv[1]) == "study")
        return bad_input(
            "study: expected the Python package, found the program alone; pip install . in a "
            "clone, then pliant study or python3 -m pliant.study");
    const auto named = [&](const CLI::App* command) { return command->get_name() == argv[1]; };
    if (argc > 1 && argv[1][0] != '-' && app.get_subcommands(named).empty())
        return bad_input("unknown command '" + std::string(argv[1]) +
                         "', expected info, convert, phantom, deform, body, render, mesh, path, "
                         "serve, replay, bench, fit, haptics, vessel, truth, morph, materials or "
                         "conformance");
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& done) {
        return app.exit(done);
    } catch (const CLI::ParseError& error) {
        return bad_input(std::string(error.what()) + " (see pliant --help)");
    }
    if (app.got_subcommand("info")) return run_info(info);
    if (app.got_subcommand("convert")) return run_convert(convert);
    if (app.got_subcommand("phantom")) return run_phantom(phantom);
    if (app.got_subcommand("deform")) return run_deform(deform);
    if (app.got_subcommand("body")) return run_body(body);
    if (app.got_subcommand("mesh")) return run_mesh(mesh);
    if (app.got_subcommand("path")) return run_path(path);
    if (app.got_subcommand("serve")) return run_serve(serve);
    if (app.got_subcommand("replay")) return run_replay(replay);
    if (app.got_subcommand("bench")) return run_bench(bench);
    if (app.got_subcommand("fit")) return run_fit(fit);
    if (app.got_subcommand("haptics")) return run_haptics(haptics);
    if (app.got_subcommand("vessel")) return run_vessel(vessel);
    if (app.got_subcommand("morph")) return run_morph(morph);
    if (app.got_subcommand("materials")) return run_materials(materials);
    if (app.got_subcommand("conformance")) return run_conformance(conformance);
    if (app.got_subcommand("truth"))
        return app.get_subcommand("truth")->got_subcommand("make") ? run_truth_make(truth.make)
                                                                   : run_truth_score(truth.score);
    return run_render(render);
}

/// Ends after an error without a file or option to name. Doesn't allocate.
int failed(const char* why) noexcept {
    clear_progress_line();
    return say_why(why);
}

/// Prints a line about the outputs of an earlier run.
void tell(const char* line) {
    clear_progress_line();
    std::fprintf(stderr, "pliant: %s\n", one_line(line).c_str());
}

/// Flushes standard output; its disk may be full or its reader gone. The output files are complete
/// then.
int finished(int status) {
    errno = 0;
    const bool is_written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
    if (is_written || status != kExitOk) return status;
    return bad_input("standard output: can't be written (" +
                     std::generic_category().message(errno ? errno : EIO) + ")");
}

}  // namespace
}  // namespace pliant::app

int main(int argc, char** argv) {
    using pliant::app::failed;
    pliant::app::guard_process();
    pliant::set_recovery_listener(pliant::app::tell);
    try {
        return pliant::app::finished(pliant::app::run(argc, argv));
    } catch (const std::bad_alloc&) {
        return failed("out of memory");
    } catch (const std::length_error&) {
        return failed("out of memory");
    } catch (const std::system_error& error) {  // from threads and files
        return failed(error.what());
    } catch (const std::exception& error) {
        return failed(error.what());
    } catch (...) {
        return failed("ended by an error of the program");
    }
}
