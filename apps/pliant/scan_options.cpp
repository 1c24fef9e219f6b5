// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Options of the commands that process a scan, except `pliant deform`.

#include <cmath>

#include "commands.h"
#include "common_options.h"

namespace pliant::app {
namespace {

constexpr const char* kScanKinds =
    "NRRD, MetaImage, NIfTI, VTI, VTK structured points, DICOM file or folder";

}  // namespace

void add_info(CLI::App& app, InfoOptions& o) {
    auto* c = app.add_subcommand("info", "Describe a scan");
    c->add_option("FILE", o.file, kScanKinds)->required();
    add_scan(c, o.scan);
    c->add_flag("--suggest-push", o.suggest_push, "a point on a wall that gives way");
    add_surface(c, o.iso_hu, o.polarity, "threshold of that wall");
    c->add_flag("--json", o.json, "one JSON object");
    c->footer("Example:\n  pliant info scan.nrrd --suggest-push");
}

void add_convert(CLI::App& app, ConvertOptions& o) {
    auto* c = app.add_subcommand("convert", "Write a scan in another format");
    c->add_option("FILE", o.file, kScanKinds)->required();
    c->add_option("OUT", o.out,
                  "file to write: .nrrd, .nhdr, .mha, .mhd, .nii, .nii.gz or .vti (ParaView)")
        ->required();
    add_scan(c, o.scan);
    c->add_flag("--raw", o.raw, "no compression (NRRD, MetaImage; .nii never has any)");
    c->add_flag("--json", o.json, "report the written files as one JSON object");
    c->footer(
        "Examples:\n"
        "  pliant convert dicom/ scan.nii.gz\n"
        "  pliant convert scan.nrrd scan.mha --raw\n"
        "  pliant convert perfusion.nii.gz third.nrrd --frame 2\n"
        "  pliant convert tilted/ straight.nrrd --straighten");
}

void add_phantom(CLI::App& app, PhantomOptions& o) {
    auto* c = app.add_subcommand("phantom", "Make a test scan from analytic shapes");
    c->add_option("NAME", o.name, "cube, layers, airway, sinus, vessel or knee")->required();
    c->add_option("--out", o.out, "file to write (.nrrd, .nhdr, .mha, .nii.gz, .vti …)")
        ->required();
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

void add_render(CLI::App& app, RenderOptions& o) {
    auto* c = app.add_subcommand("render", "Draw the endoscope's view and the sections");
    c->add_option("FILE", o.file, kScanKinds)->required();
    add_scan(c, o.scan);
    c->add_option("--load-state", o.load_state,
                  "deform the scan by a state of deform --save-state (.plst)");
    c->add_option("--out", o.out, "PNG file to write");
    c->add_option("--path", o.path, "curve of 3D Slicer (.mrk.json) to fly along");
    c->add_option("--keyframes", o.keyframes, "cameras that the page saved (.json), for a movie");
    c->add_option("--movie", o.movie, "file of the flight (.mp4, made by ffmpeg), or folder/");
    c->add_option("--speed", o.speed_mm_s, "of the flight [mm/s] (default 20)")
        ->check(CLI::Range(0.001, 1000.0));
    c->add_option("--view", o.view,
                  "four-up, endoscope, blended, fluoroscopy, axial, coronal or sagittal")
        ->check(CLI::IsMember(
            {"four-up", "endoscope", "blended", "fluoroscopy", "axial", "coronal", "sagittal"}));
    add_surface(c, o.iso_hu, o.polarity, "threshold of the surface");
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
    add_look(c, o.look_of);
    add_window(c, o.window_hu, o.level_hu, "; blended: 500", "; blended: 150");
    c->add_option("--opacity", o.opacity_per_mm, "blended: at the window's upper end [1/mm]")
        ->check(CLI::Range(0.0, 1000.0));
    c->add_option("--source", o.source_mm, "fluoroscopy: from the source to --at [mm] (1000)")
        ->check(CLI::Range(10.0, 1e6));
    c->add_option("--width", o.width_mm,
                  "fluoroscopy: that is shown at --at [mm] (its longest side)")
        ->check(CLI::Range(1.0, 1e5));
    c->add_option("--exposure", o.exposure_water_mm,
                  "fluoroscopy: water that is 45 % grey [mm] (metered)")
        ->check(CLI::Range(0.0, 1e5));
    c->add_option(
         "--border", o.border_mm,
         "fluoroscopy: over which the scan fades out [mm]; 0: a sharp edge (a third of it)")
        ->check(CLI::Range(0.0, 1e5));
    c->add_option("--noise", o.noise, "fluoroscopy: factor of the quantum noise; 0: none (1)")
        ->check(CLI::Range(0.0, 100.0));
    c->add_option("--seed", o.seed, "fluoroscopy: of the noise (0)");
    c->add_option("--contrast", o.contrast, "fluoroscopy: factor of the line integral (1)")
        ->check(CLI::Range(0.01, 100.0));
    add_threads(c, o.threads);
    c->footer(
        "Example:\n  pliant render scan.nrrd --eye -13.5,116,-411 --look 0,0.7,-0.7 "
        "--out view.png");
}

void add_path(CLI::App& app, PathOptions& o) {
    auto* c = app.add_subcommand("path", "Find the way through a lumen, along its middle");
    c->add_option("FILE", o.file, kScanKinds)->required();
    add_scan(c, o.scan, "--voxel-spacing");
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
    add_surface(c, o.iso_hu, o.polarity, "threshold of the wall");
    c->add_option("--reach", o.reach_mm, "an end in the tissue moves so far into a lumen [mm]")
        ->check(CLI::Range(0.0, 100.0));
    c->add_option("--spacing", o.spacing_mm, "between points, at most [mm] (default 2)")
        ->check(CLI::Range(0.0005, 100.0));
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
        "mesh",
        "Make tetrahedra of a vessel's wall or of an organ, or judge a mesh (docs/method/mesh.md)");
    c->add_option(
         "FILE", o.file,
         "scan or label volume; surface or centreline (VTP, VTU, VTK, MSH, STL, OBJ, PLY, OFF, "
         "Medit's MESH)")
        ->required();
    add_scan(c, o.scan);
    add_units(c, o.units);
    auto* out =
        c->add_option("--out", o.out, "tetrahedra to write (.vtu); else FILE is only judged");
    auto* solid = c->add_flag("--solid", o.solid,
                              "fill a closed surface, or --labels, instead of making a wall")
                      ->needs(out);
    c->add_option("--tetrahedra", o.tetrahedra,
                  "approximate number in the solid if --cell is not given (default 20000)")
        ->check(CLI::Range(24, 10'000'000))
        ->needs(solid);
    c->add_option("--ghost", o.ghost, "its inner surface (.vtp, .stl, .obj, .ply)")->needs(out);
    c->add_option("--surface", o.surface,
                  "the lumen's or the solid's surface, of a scan (.vtp, .stl, .obj, .ply)")
        ->needs(out);
    c->add_option("--thickness", o.thickness_mm, "of the wall [mm] (default 1.5)")
        ->check(CLI::Range(0.01, 100.0));
    c->add_option("--layers", o.layers, "tetrahedra across it, at least (default 2)")
        ->check(CLI::Range(1, 16));
    c->add_option("--cell", o.cell_mm,
                  "of the lattice [mm] (default: the largest that the layers allow; solid: by "
                  "--tetrahedra)")
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
         "values of the lumen")
        ->type_name("LOW,HIGH")
        ->needs(seed);
    add_vector(c, "--to", o.to_mm, "keep to the way through the lumen from the seed to here")
        ->needs(seed);
    c->add_option("--within", o.within_mm, "how far from that way [mm] (default 15)")
        ->check(CLI::Range(0.1, 1000.0));
    c->add_option("--most-ml", o.max_ml,
                  "a larger region leaks, and is refused (default 500; 0: any)")
        ->check(CLI::Range(0.0, 1e6));
    c->add_option("--labels", o.labels, "instead: labels of the lumen or the solid, as 1,2")
        ->delimiter(',')
        ->excludes(seed);
    c->add_option("--smooth", o.smoothing_voxels, "the labels' edge, voxels (default 0.8)")
        ->check(CLI::Range(0.0, 20.0));
    c->add_flag("--json", o.json, "say the mesh's quality as one JSON object");
    add_threads(c, o.threads);
    for (const char* of_walls : {"--ghost", "--thickness", "--layers", "--ghost-cell", "--ends",
                                 "--trim", "--sweep", "--sectors", "--seed"})
        solid->excludes(c->get_option(of_walls));
    c->footer(
        "Examples:\n"
        "  pliant mesh centreline.vtp --thickness 1.5 --out wall.vtu --ghost ghost.vtp\n"
        "  pliant mesh surface.vtp --ends centreline.vtp --out wall.vtu\n"
        "  pliant mesh angio.nrrd --seed=-6,-31,1180 --window 150,600 --out wall.vtu\n"
        "  pliant mesh angio.nrrd --seed=-3,-149,545 --to=18,-149,746 --window 250,3500 "
        "--out wall.vtu\n"
        "  pliant mesh labels.nii.gz --labels 1,2 --out wall.vtu\n"
        "  pliant mesh liver.stl --solid --tetrahedra 10000 --out liver.vtu\n"
        "  pliant mesh labels.nii.gz --labels 5 --solid --cell 8 --out liver.vtu\n"
        "  pliant mesh wall.vtu");
}

}  // namespace pliant::app
