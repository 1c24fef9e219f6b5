// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Options of the command line as plain values. The …_options.cpp files fill them; each run_…
// function does the work.
//
// Exit status: 0 done, 2 bad input (one line on standard error with the file or option and the
// expected value; no output file is touched).

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/vec.h>
#include <pliant/models/material.h>
#include <pliant/scan_files.h>
#include <pliant/tool.h>
#include <pliant/volume.h>

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace pliant::app {

inline constexpr int kExitOk = 0;
inline constexpr int kExitBadInput = 2;

/// Choice of a scan in a file or folder.
struct ScanChoice {
    std::string series;  ///< DICOM
    std::optional<std::int64_t> frame;
    bool straighten = false;
    std::optional<Vec3d> spacing_mm;  ///< of DICOM without positions

    ReadOptions options() const {
        ReadOptions options;
        options.series_uid = series;
        options.frame = frame;
        options.straighten = straighten;
        options.spacing_mm = spacing_mm;
        return options;
    }
};

struct InfoOptions {
    std::string file;
    ScanChoice scan;
    bool suggest_push = false;
    std::optional<double> iso_hu;  ///< of the suggested push's wall; nullopt: by the scan's values
    std::optional<std::string> polarity;
    bool json = false;
};

struct ConvertOptions {
    std::string file;
    ScanChoice scan;
    std::string out;
    bool raw = false;
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

/// A sphere's path along a vector; tissue slides off it.
struct SlideOption {
    Vec3d point_mm;
    Vec3d way_mm;
};

/// Actions on the tissue, in order.
using DeformAction = std::variant<PushOption, SlideOption, CutSurface, CarveTool>;

/// Lighting and colours of the endoscope's picture.
struct LookOptions {
    std::string style = "plain", lining = "auto", field_stop = "round";
};

/// Picture before and after a deformation.
struct PictureOptions {
    std::string png;                    ///< empty: none
    std::optional<Vec3d> eye_mm, look;  ///< camera
    // Defaults follow from the scan's values.
    std::optional<double> iso_hu, window_hu, level_hu;
    std::optional<std::string> polarity;
    LookOptions look_of;
    bool shows_tool = false;  ///< outlines the tool of the last push or slide
};

struct DeformOptions {
    std::string model = "chainmail";  ///< or another of tissue_models()
    // Options of models other than chainmail.
    /// By the names of spring_rows(), body_rows(), network_rows() and elastic_scan_rows().
    Record settings;
    std::optional<std::pair<Vec3d, Vec3d>> region_mm;  ///< two opposite corners
    std::optional<int> steps;                          ///< nullopt: until it is at rest
    std::optional<double> depth_within_mm;  ///< depth found after the pushes (Tissue::take_depth)
    std::string mesh;                       ///< the body's tetrahedra
    std::string units;                      ///< of MeshOptions
    std::string network;                    ///< springs in place of a lattice's
    std::string file;
    ScanChoice scan;
    std::vector<DeformAction> actions;  ///< in the order of the command line
    double sphere_radius_mm = 0;        ///< 0: the point tool
    std::string config;
    std::string labels, directions;   ///< for [[label]] of the config
    std::optional<double> relax_ms;   ///< budget of the relaxation after all actions; nullopt:
                                      ///< unlimited
    std::optional<int> relax_sweeps;  ///< with both limits, the first one ends it; neither: none
    bool release = false;             ///< the tool is removed before the relaxation; otherwise it
                                      ///< stays
    PictureOptions picture;
    std::string solver;             ///< "sweep" or "heap"; empty: sweep
    std::string mapping = "cells";  ///< or "tetrahedra"
    std::string load_state, save_state;
    std::string out, labels_out, displacement, transform, jacobian, strain, report;
    std::string mesh_out;  ///< of pliant body: the moved mesh
    bool raw = false;
    int threads = 0;
};

/// Options of `pliant body`, which deforms like `pliant deform`.
struct BodyOptions {
    std::string labels, label_names;
    std::optional<std::vector<int>> bodies;  ///< as of ServeOptions
    DeformOptions deform{};
};

struct RenderOptions {
    std::string file;
    ScanChoice scan;
    std::string load_state;  ///< state of the tissue; empty: at rest
    std::string out;
    std::string path, movie;           ///< a flight along a curve; out and eye are then ignored
    std::string keyframes;             ///< a movie from the page's keyframes, instead of a path
    std::optional<double> speed_mm_s;  ///< of the flight; nullopt: 20, less in a small specimen
    std::string view = "four-up";  ///< endoscope | blended | fluoroscopy | axial | coronal | …
    int width = 0, height = 0;     ///< 0: 1024×1024 for four-up, 512×512 for one view
    // Defaults follow from the scan's values.
    std::optional<double> iso_hu;
    std::optional<std::string> polarity;
    std::optional<Vec3d> eye_mm, look, up, at_mm;
    double field_of_view_deg = 80;
    double barrel_distortion = 0.15;
    std::optional<double> fog_distance_mm;      ///< nullopt: 120, less in a small specimen
    std::optional<std::string> colour;          ///< "R,G,B" 0…255
    LookOptions look_of;                        ///< for the endoscope's picture
    std::optional<double> window_hu, level_hu;  ///< of sections, or of the opacity in the blended
                                                ///< view
    std::optional<double> opacity_per_mm;       ///< nullopt: 0.25, more in a small specimen
    // Fluoroscopy; without a width the whole scan is shown.
    double source_mm = 1000, contrast = 1, noise = 1;
    std::uint32_t seed = 0;
    std::optional<double> width_mm, exposure_water_mm, border_mm;
    int threads = 0;
};

struct PathOptions {
    std::string file;
    ScanChoice scan;
    std::string out;
    Vec3d from_mm{0, 0, 0}, to_mm{0, 0, 0};
    std::optional<double> iso_hu;  ///< nullopt: by the scan's values
    std::optional<std::string> polarity;
    double reach_mm = 0;
    std::optional<double> spacing_mm;  ///< nullopt: 2, less in a small specimen
    bool json = false;
    int threads = 0;
};

struct MeshOptions {
    std::string file;   ///< a scan, a surface, a centreline or tetrahedra
    std::string units;  ///< of lengths in a mesh's file: "mm", "cm" or "m"; empty: mm
    ScanChoice scan;
    std::string out, ghost, surface;   ///< outputs; none: only report on the file's mesh
    bool solid = false;                ///< a solid instead of a vessel's wall
    std::int64_t tetrahedra = 20'000;  ///< of the solid, about
    double thickness_mm = 1.5, cell_mm = 0, ghost_mm = 0;
    int layers = 2;
    std::string ends;   ///< a centreline that defines the wall's ends
    double trim = 0.5;  ///< distance by which ends move inwards, in radii
    bool sweep = false;
    int sectors = 24;
    std::optional<Vec3d> seed_mm;  ///< of region growing
    double low = 0, high = 0;      ///< range of its values
    std::optional<Vec3d> to_mm;    ///< limits the region to the path from the seed to this point
    double within_mm = 15, max_ml = 500;
    std::vector<int> labels;  ///< alternative to the seed: voxels with these labels
    double smoothing_voxels = 0.8;
    bool json = false;
    int threads = 0;
};

struct VesselOptions {
    std::string scene;
    /// Outputs, and a log to replay.
    std::string report, csv, frames, record, replay, volume, png;
    int every = 50;  ///< steps per frame
    bool json = false;
    int threads = 0;
};

struct ServeOptions {
    std::string file;  ///< empty: the airway phantom
    ScanChoice scan;
    std::string labels, label_names;         ///< map over the scan, and table of its names
    std::optional<std::vector<int>> bodies;  ///< labels; empty: of all organs; none: no bodies
    std::string model = "auto";              ///< of the tissue at first
    std::string config, directions;          ///< materials
    std::string units;                       ///< of MeshOptions; empty: the scene's own
    std::string network;                     ///< springs that move the scan or the organ
    std::string load_state;                  ///< state of the tissue; empty: at rest
    int port = 8765;
    bool port_given = false;  ///< false: a free port may replace it
    std::string host = "127.0.0.1", certificate, key, url;
    std::vector<std::string> embed_in;  ///< origins that may show the page in a frame
    std::string session, replay;
    double checkpoint_s = 30;
    int spring_nodes = 32;
    int network_hz = 25;
    bool no_open = false;
    std::vector<std::string> haptics;  ///< devices beside the built-in ones
    int threads = 0;
};

struct ReplayOptions {
    std::string session;
    std::string out, displacement, transform, save_state;  ///< of the last state; empty: none
    PictureOptions picture;                                ///< without a threshold: the session's
    bool from_checkpoint = false;
    bool json = false;
    int threads = 0;
};

struct BenchOptions {
    std::string what;              ///< "chainmail"
    bool compare = false;          ///< the solvers with each other
    bool json = false;             ///< one object per case and solver, one on each line
    int size = 50;                 ///< elements along each edge of the lattice
    double pull_voxels = 5;        ///< length of the push, and of the drag's longest step
    std::string grab = "element";  ///< or "cell"
    bool homogeneous = false, heterogeneous = false;  ///< neither: both
    double shear_ratio = 0.5;  ///< shear / stretch of the heterogeneous materials
    int rounds = 9;
    int threads = 1;
};

/// A box of elastic material and its lattice of springs, or a mesh and the springs of its edges.
/// Composite values are kept as the user's text.
struct FitOptions {
    std::string config;
    // Fit of a mesh.
    std::string mesh;                    ///< tetrahedra, or a closed surface; empty: a box
    std::string units;                   ///< of MeshOptions
    std::int64_t tetrahedra = 5000;      ///< of a filled surface, about
    std::vector<std::string> hold;       ///< X,Y,Z:X,Y,Z or NAME=VALUE
    std::vector<std::string> targets;    ///< measurements of each load
    std::string regions;                 ///< array of the mesh's file
    std::string labels;                  ///< label volume, for regions
    std::vector<std::string> materials;  ///< LABEL:YOUNG[,POISSON]
    std::string creep;                   ///< displacements over time, CSV
    std::string network_out, out;        ///< network file; VTU
    // Fit of a box.
    std::string size = "10,10,10", spacing_mm = "11.111111";
    // Defaults: 6e5 Pa and 1040 kg/m³ (elastin) for a box, 15e3 and 1000 for a mesh.
    std::optional<double> young_pa, density_kg_m3;
    double poisson = 0.45;
    std::string fibre;  ///< X,Y,Z; empty: isotropic
    std::optional<double> fibre_young_pa, fibre_poisson, fibre_shear_pa;
    std::string element = "trilinear";
    std::string held = "-z";
    /// Box: FACE:FX,FY,FZ[:ACROSS,ALONG[:NODES]]. Mesh: a place as of `hold`, and :FX,FY,FZ
    std::vector<std::string> loads, held_out;
    std::string links = "edges+faces";
    std::string groups = "uniform";
    bool volume = false, by_cells = false;
    double damping_kg_s = 0;  ///< above 0: fitted as a separate value, with this initial value
    std::string motion = "linear";
    double duration_s = 1;
    int depth = 10;
    std::string cost = "distances";
    double range = 10;
    double noise_mm = 0;               ///< above 0: confidence intervals
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
    double update_hz = 30;  ///< solution rate of the tissue
    bool load = false;
    std::string out, record;
    bool json = false;
    int threads = 0;
};

struct TruthMakeOptions {
    std::string file;
    ScanChoice scan;
    std::string out;
    int cases = 1;
    std::uint64_t seed = 1;
    Record given;                     ///< settings of TruthSettings
    std::string model = "chainmail";  ///< or "elastic"
    Record tissue;                    ///< settings of elastic_scan_rows()
    std::string config;
    std::string format = "nrrd";
    bool raw = false;
    int threads = 0;
};

struct TruthScoreOptions {
    std::string folder;
    std::vector<std::string> fields, transforms, points;  ///< [NAME=]PATTERN
    bool ras = false;
    std::string csv, report, markdown, page;
    int threads = 0;
};

struct TruthOptions {
    TruthMakeOptions make;
    TruthScoreOptions score;
};

struct MorphOptions {
    std::string from, to;             ///< label maps; empty: none
    std::string points;               ///< table of known points
    std::string predict;              ///< table of points to move
    std::string axes = "auto";        ///< of both tables, or "lps", "ras"
    std::string scan;                 ///< moved by --volume; its grid is that of the fields
    std::vector<std::string> moduli;  ///< LABEL=RATIO
    Record given;                     ///< settings of MorphSettings
    std::string out, displacement, transform, jacobian, volume, report;
    bool raw = false;
    int threads = 0;
};

struct MaterialsOptions {
    std::string name;  ///< empty: all
    bool json = false;
};

struct ConformanceOptions {
    std::vector<std::string> parts;  ///< empty: all
    std::string html;                ///< empty: no page
    bool json = false;
};

int run_info(const InfoOptions& options);
int run_convert(const ConvertOptions& options);
int run_phantom(const PhantomOptions& options);
int run_deform(const DeformOptions& options);
int run_body(const BodyOptions& options);
int run_render(const RenderOptions& options);
int run_mesh(const MeshOptions& options);
int run_path(const PathOptions& options);
int run_vessel(const VesselOptions& options);
int run_serve(const ServeOptions& options);
int run_replay(const ReplayOptions& options);
int run_bench(const BenchOptions& options);
int run_fit(const FitOptions& options);
int run_haptics(const HapticsOptions& options);
int run_truth_make(const TruthMakeOptions& options);
int run_truth_score(const TruthScoreOptions& options);
int run_morph(const MorphOptions& options);
int run_materials(const MaterialsOptions& options);
int run_conformance(const ConformanceOptions& options);

/// Prints "pliant: message" as one line on standard error. @returns kExitBadInput
int bad_input(const std::string& message);
/// The same, with a table of series to choose from below the message.
int bad_input(const Error& error);

}  // namespace pliant::app
