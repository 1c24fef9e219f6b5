// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fit_options.h"

#include <pliant/core/files.h>

#include <CLI/CLI.hpp>
#include <sstream>

#include "common_options.h"

namespace pliant::app {
namespace {

/// Reads options that are not on the command line from lines NAME = VALUE of a TOML file.
void read_fit_config(CLI::App* command, const std::string& file) {
    std::vector<CLI::ConfigItem> items;
    const auto text = read_small_file(file, kMaxSmallFileBytes, "a settings file");
    if (!text) throw CLI::ValidationError(text.error().message);
    if (const Status s = check_nesting(*text, TextSyntax::Toml); !s)
        throw CLI::ValidationError(file, s.error().message);
    try {
        std::istringstream stream(*text);
        items = CLI::ConfigTOML().from_config(stream);
    } catch (const CLI::Error& error) {
        throw CLI::ValidationError(file, error.what());
    }
    for (const CLI::ConfigItem& item : items) {
        CLI::Option* option = command->get_option_no_throw("--" + item.name);
        if (!item.parents.empty() || !option || item.name == "help")
            throw CLI::ValidationError(file, "unknown setting '" + shown(item.fullname()) +
                                                 "'; expected the names of pliant fit --help");
        if (!option->empty()) continue;
        const bool is_off = option->get_items_expected_max() == 0 && item.inputs.size() == 1 &&
                            item.inputs[0] == "false";
        if (is_off) continue;
        for (const std::string& input : item.inputs) option->add_result(input);
        option->run_callback();
    }
}

/// Options of a box alone.
void add_box(CLI::App* c, FitOptions& o) {
    const char* const group = "Without --mesh: a box";
    const auto add = [&](CLI::Option* option) { option->group(group); };
    add(c->add_option("--size", o.size, "nodes of the box along x, y, z (default 10,10,10)"));
    add(c->add_option("--spacing", o.spacing_mm, "between nodes, one or three numbers [mm]"));
    add(c->add_option("--element", o.element, "of the reference (default trilinear)")
            ->check(CLI::IsMember({"trilinear", "incompatible"})));
    add(c->add_option("--fibre", o.fibre,
                      "direction of the reference's fibres; --young and --poisson are then those "
                      "across them, and the next three are needed")
            ->type_name("X,Y,Z"));
    add(c->add_option("--fibre-young", o.fibre_young_pa, "Young's modulus along fibres [Pa]"));
    add(c->add_option("--fibre-poisson", o.fibre_poisson,
                      "contraction across for extension along the fibres"));
    add(c->add_option("--fibre-shear", o.fibre_shear_pa,
                      "shear modulus in planes with the fibres [Pa]"));
    const CLI::IsMember face({"-x", "+x", "-y", "+y", "-z", "+z"});
    add(c->add_option("--held", o.held, "face that doesn't move (default -z)")->check(face));
    add(c->add_option("--links", o.links, "of the lattice (default edges+faces)")
            ->check(CLI::IsMember({"edges", "edges+faces", "edges+faces+body"})));
    add(c->add_option("--groups", o.groups, "partition of the links (default uniform)")
            ->check(CLI::IsMember({"uniform", "kinds", "directions"})));
    add(c->add_flag("--by-cells", o.by_cells, "each cell has its own springs"));
    add(c->add_option("--damping", o.damping_kg_s, "fit the nodes' damping, starting here [kg/s]")
            ->check(CLI::NonNegativeNumber));
}

/// Options of a mesh alone.
void add_mesh_fit(CLI::App* c, FitOptions& o) {
    const char* const group = "With --mesh";
    const char* const place = "X,Y,Z:X,Y,Z|NAME=VALUE";
    CLI::Option* mesh = c->add_option("--mesh", o.mesh,
                                      "tetrahedra, or a closed surface, in LPS (.vtu, .vtk, "
                                      ".msh, .vtp, .stl, .obj, .ply); its edges become links")
                            ->group(group);
    add_units(c, o.units)->needs(mesh)->group(group);
    for (const char* box :
         {"--size", "--spacing", "--fibre", "--fibre-young", "--fibre-poisson", "--fibre-shear",
          "--element", "--held", "--links", "--groups", "--by-cells", "--damping"})
        mesh->excludes(c->get_option(box));
    const auto add = [&](CLI::Option* option) { option->group(group)->needs(mesh); };
    add(c->add_option("--tetrahedra", o.tetrahedra, "of a filled surface, about (default 5000)")
            ->check(CLI::Range(100, 100000)));
    add(c->add_option("--hold", o.hold,
                      "nodes that don't move: those in a box, or with a value in an array of the "
                      "mesh's file; repeatable")
            ->type_name(place));
    add(c->add_option("--target", o.targets,
                      "measured displacements of a load: CSV with node,dx,dy,dz or x,y,z,dx,dy,dz "
                      "[mm], or VTU with a vector array (default displacement_mm); one for each "
                      "--load, then each --held-out (default: finite elements)")
            ->type_name("FILE[:ARRAY]"));
    add(c->add_option("--regions", o.regions,
                      "array of the mesh's file; each of its values is a tissue"));
    add(c->add_option("--labels", o.labels, "label volume; each of its labels is a tissue"));
    add(c->add_option("--material", o.materials,
                      "Young's modulus [Pa] and Poisson's ratio of a tissue; repeatable")
            ->type_name("LABEL:YOUNG[,POISSON]"));
    add(c->add_option("--creep", o.creep,
                      "displacements under the first load over time, CSV with time_s,node,dx,dy,dz "
                      "[mm]: fits the damping"));
    add(c->add_option("--network-out", o.network_out,
                      "network of the last method (JSON), for deform and serve"));
    add(c->add_option("--out", o.out, "displacements, residuals and regions (.vtu)"));
}

}  // namespace

void add_fit(CLI::App& app, FitOptions& o) {
    auto* c = app.add_subcommand("fit", "Find spring stiffnesses that move as finite elements do");
    c->add_option("CONFIG", o.config, "settings, TOML: the names below without dashes");
    add_box(c, o);
    c->add_option("--young", o.young_pa, "Young's modulus [Pa] (default 600000; of a mesh 15000)");
    c->add_option("--poisson", o.poisson, "Poisson's ratio (default 0.45)");
    c->add_option("--density", o.density_kg_m3, "[kg/m3] (default 1040; of a mesh 1000)");
    const char* load = "FACE:FX,FY,FZ[:ACROSS,ALONG[:NODES]]|PLACE:FX,FY,FZ";
    c->add_option("--load", o.loads,
                  "total force [N] on NODES x NODES nodes (default 2) of a face, around a point "
                  "from 0,0 to 1,1 on it (default 0.5,0.5); with --mesh, on the nodes at a place, "
                  "as of --hold; repeatable (default of a box +z:0,0,-40)")
        ->type_name(load);
    c->add_option("--held-out", o.held_out, "a load for evaluation only")->type_name(load);
    c->add_flag("--volume", o.volume, "add a volume energy of the cells");
    add_mesh_fit(c, o);
    c->add_option("--motion", o.motion, "linear, equilibrium, or run: stopped after a time")
        ->check(CLI::IsMember({"linear", "equilibrium", "run"}));
    c->add_option("--duration", o.duration_s, "of a run [s] (default 1)")
        ->check(CLI::PositiveNumber);
    c->add_option("--depth", o.depth, "of a run [layers] (default 10)")->check(CLI::Range(0, 1000));
    c->add_option("--cost", o.cost, "sum of distances, or of their squares")
        ->check(CLI::IsMember({"distances", "squares"}));
    c->add_option("--noise-mm", o.noise_mm,
                  "standard deviation of a component of a displacement: confidence intervals")
        ->check(CLI::PositiveNumber);
    c->add_option("--range", o.range, "bounds: the start over this and times this (default 10)");
    c->add_option("--method", o.methods, "repeatable (default closed-form, gauss-newton)")
        ->check(CLI::IsMember({"closed-form", "gauss-newton", "annealing"}));
    c->add_option("--evaluations", o.evaluations, "at most, of a search (default 400)")
        ->check(CLI::Range(1, 1000000));
    c->add_option("--seed", o.seed, "of annealing (default 1)");
    c->add_option("--temperature", o.start_temperature, "start of annealing; 0: automatic");
    c->add_option("--cooling", o.cooling, "of annealing, beta; 0: automatic");
    c->add_option("--report", o.report, "report, JSON");
    c->add_option("--threads", o.threads, "threads to use; 0: all")->check(CLI::Range(0, 256));
    c->final_callback([c, &o] {
        if (!o.config.empty()) read_fit_config(c, o.config);
    });
    c->footer(
        "Stiffness is in N/m, bulk in Pa, damping in kg/s, errors in percent of the spacing; of a "
        "mesh moduli in Pa, damping in 1/s, errors in percent of the mean edge.\n"
        "Examples:\n"
        "  pliant fit --load +z:0,0,-40 --method closed-form --method gauss-newton "
        "--method annealing\n"
        "  pliant fit --volume --by-cells --groups kinds --load +z:0,0,-40:0.2,0.3 "
        "--load +z:40,0,0:0.7,0.3 --held-out +z:0,0,-40 --report fit.json\n"
        "  pliant fit --size 6,6,6 --spacing 5 --young 12000 --poisson 0.2 --fibre 1,0,0 "
        "--fibre-young 34000 --fibre-poisson 0.4 --fibre-shear 8000 --by-cells --groups directions "
        "--load +z:0,0,-0.01 --load +z:0.01,0,0 --load +x:0.01,0,0 --held-out +z:0,-0.01,0\n"
        "  pliant fit scenes/fit_elastin.toml\n"
        "  pliant fit --mesh organ.vtu --volume --hold -50,40,-50:50,60,50 "
        "--load -5,-40,-5:5,-30,5:0,2,0 --target measured.csv --noise-mm 0.1 "
        "--network-out fit.json --out fitted.vtu");
}

}  // namespace pliant::app
