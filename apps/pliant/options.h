// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What the command line says, as plain values. The …_options.cpp fill them; each run_… does the
// work.
//
// Exit status: 0 done, 2 bad input (one line on standard error that names the file or option and
// what was expected; no output file touched).

#pragma once

#include <pliant/chainmail_edits.h>
#include <pliant/record.h>
#include <pliant/vec.h>

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace pliant::app {

inline constexpr int kExitOk = 0;
inline constexpr int kExitBadInput = 2;

struct InfoOptions {
    std::string file;
    std::string series;
    bool suggest_push = false;
    bool json = false;
};

struct PhantomOptions {
    std::string name;
    std::string out;
    Vec3i size{128, 128, 128};
    Vec3d spacing_mm{0, 0, 0};             ///< zero: the phantom's extent / size
    std::optional<std::string> direction;  ///< nine numbers, columns of the direction matrix
    bool raw = false;
    int threads = 0;
};

struct PushOption {
    Vec3d point_mm;
    Vec3d push_mm;
};

/// The sphere's way, from a point along a vector; tissue slides off it.
struct SlideOption {
    Vec3d point_mm;
    Vec3d way_mm;
};

/// What is done to the tissue, one after the other.
using DeformAction = std::variant<PushOption, SlideOption, CutSurface, CarveTool>;

/// Options of --model springs.
struct SpringOptions {
    Record settings;                                   ///< by the names of spring_rows()
    std::optional<std::pair<Vec3d, Vec3d>> region_mm;  ///< two opposite corners
    std::optional<int> steps;                          ///< none: until it is at rest
};

/// The endoscope's picture: what it is lit and coloured by.
struct LookOptions {
    std::string style = "plain", lining = "auto", field_stop = "round";
};

struct DeformOptions {
    std::string model = "chainmail";  ///< or "springs"
    SpringOptions springs;
    std::string file;
    std::string series;
    std::vector<DeformAction> actions;  ///< in the order of the command line
    double sphere_radius_mm = 0;        ///< 0: the point tool
    std::string config;
    std::string labels, directions;   ///< for [[label]] of the config
    std::optional<double> relax_ms;   ///< budget of the relaxation after all actions
    std::optional<int> relax_sweeps;  ///< likewise; both: whichever ends first; none: no relaxation
    bool release = false;             ///< the tool has gone before it; else it stays
    LookOptions look_of;              ///< of the picture
    std::string solver;               ///< "sweep" or "heap"; empty: sweep
    std::string mapping = "cells";    ///< or "tetrahedra"
    std::string load_state, save_state;
    std::string out, displacement, transform, jacobian, strain, report, png;
    std::optional<Vec3d> eye_mm, look;  ///< of the picture
    std::optional<double> iso_hu;
    bool raw = false;
    int threads = 0;
};

struct RenderOptions {
    std::string file;
    std::string series;
    std::string load_state;  ///< of the tissue; empty: at rest
    std::string out;
    std::string path, movie;       ///< a flight along a curve; then out and eye aren't used
    std::string keyframes;         ///< a movie of the page's keyframes, instead of a path
    double speed_mm_s = 20;        ///< of the flight
    std::string view = "four-up";  ///< endoscope | blended | fluoroscopy | axial | coronal | …
    int width = 0, height = 0;     ///< 0: 1024×1024 for four-up, 512×512 for one view
    double iso_hu = -500;
    std::string polarity = "rising";
    std::optional<Vec3d> eye_mm, look, up, at_mm;
    double field_of_view_deg = 80;
    double barrel_distortion = 0.15;
    double fog_distance_mm = 120;
    std::optional<std::string> colour;          ///< "R,G,B" 0…255
    LookOptions look_of;                        ///< of the endoscope's picture
    std::optional<double> window_hu, level_hu;  ///< of sections, or of the blended view's opacity
    double opacity_per_mm = 0.25;
    // Of fluoroscopy; no width: the whole scan.
    double source_mm = 1000, contrast = 1, noise = 1;
    std::uint32_t seed = 0;
    std::optional<double> width_mm, exposure_water_mm, border_mm;
    int threads = 0;
};

struct PathOptions {
    std::string file;
    std::string series;
    std::string out;
    Vec3d from_mm{0, 0, 0}, to_mm{0, 0, 0};
    double iso_hu = -500;
    std::string polarity = "rising";
    double reach_mm = 0;
    double spacing_mm = 2;
    bool json = false;
    int threads = 0;
};

struct MeshOptions {
    std::string file;  ///< a scan, a surface, a centreline or tetrahedra
    std::string series;
    std::string out, ghost, surface;  ///< outputs; none: the file's mesh is only judged
    double thickness_mm = 1.5, cell_mm = 0, ghost_mm = 0;
    int layers = 2;
    std::string ends;   ///< a centreline whose ends are the wall's
    double trim = 0.5;  ///< radii that the ends are moved inwards
    bool sweep = false;
    int sectors = 24;
    std::optional<Vec3d> seed_mm;  ///< of region growing
    double low = 0, high = 0;      ///< its window
    std::optional<Vec3d> to_mm;    ///< the region stays near the way from the seed to there
    double within_mm = 15, most_ml = 500;
    std::vector<int> labels;  ///< instead: voxels with one of them
    double smoothing_voxels = 0.8;
    bool json = false;
    int threads = 0;
};

struct VesselOptions {
    std::string scene;
    std::string report, csv, frames, record, replay, volume;  ///< outputs, and a log to play again
    int every = 50;                                           ///< steps from frame to frame
    bool json = false;
    int threads = 0;
};

struct ServeOptions {
    std::string file;  ///< empty: the airway phantom
    std::string series;
    int port = 8765;
    bool port_given = false;  ///< else any free one will do
    std::string session;
    double checkpoint_s = 30;
    int spring_nodes = 32;
    bool no_open = false;
    std::vector<std::string> haptics;  ///< devices beside those in the tree
    int threads = 0;
};

struct ReplayOptions {
    std::string session;
    bool from_checkpoint = false;
    bool json = false;
    int threads = 0;
};

struct BenchOptions {
    std::string what;              ///< "chainmail"
    bool compare = false;          ///< published orderings beside the exact solvers
    bool json = false;             ///< one object per case and solver, one on each line
    int size = 50;                 ///< elements along each edge of the lattice
    double pull_voxels = 5;        ///< length of the push; of the longest step of the drag
    std::string grab = "element";  ///< or "cell"
    bool homogeneous = false, heterogeneous = false;  ///< neither: both
    double shear_ratio = 0.5;  ///< shear / stretch of the heterogeneous materials
    int rounds = 9;
    int threads = 1;
};

/// A box of elastic material and a lattice of springs for it; text as the user gave it where it is
/// more than a number.
struct FitOptions {
    std::string config;
    std::string size = "10,10,10", spacing_mm = "11.111111";
    double young_pa = 6e5, poisson = 0.45, density_kg_m3 = 1040;
    std::string element = "trilinear";
    std::string held = "-z";
    std::vector<std::string> loads, held_out;  ///< FACE:FX,FY,FZ[:ACROSS,ALONG[:NODES]]
    std::string links = "edges+faces";
    std::string groups = "uniform";
    bool volume = false, by_cells = false;
    double damping_kg_s = 0;  ///< above 0: a value of its own, that starts here
    std::string motion = "linear";
    double duration_s = 1;
    int depth = 10;
    std::string cost = "distances";
    double range = 10;
    std::vector<std::string> methods;  ///< empty: closed-form and gauss-newton
    int evaluations = 400;
    std::uint64_t seed = 1;
    double start_temperature = 0, cooling = 0;
    std::string report;
    int threads = 0;
};

struct HapticsOptions {
    std::string what;  ///< "check" or "devices"
    std::string device = "virtual:active";
    double minutes = 10;
    double rate_hz = 1000;
    double update_hz = 30;  ///< of the tissue
    bool load = false;
    std::string out, record;
    bool json = false;
    int threads = 0;
};

int run_info(const InfoOptions& options);
int run_phantom(const PhantomOptions& options);
int run_deform(const DeformOptions& options);
int run_deform_springs(const DeformOptions& options);
int run_render(const RenderOptions& options);
int run_mesh(const MeshOptions& options);
int run_path(const PathOptions& options);
int run_vessel(const VesselOptions& options);
int run_serve(const ServeOptions& options);
int run_replay(const ReplayOptions& options);
int run_bench(const BenchOptions& options);
int run_fit(const FitOptions& options);
int run_haptics(const HapticsOptions& options);

/// Prints "pliant: message" as one line on standard error. @returns kExitBadInput
int bad_input(const std::string& message);

}  // namespace pliant::app
