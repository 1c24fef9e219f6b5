// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Motion of an organ between two phases: label maps and known points in, predicted points and
// fields out. MorphOutputs appear together at the end.

#include <pliant/core/files.h>
#include <pliant/core/text.h>
#include <pliant/core/version.h>
#include <pliant/data/morph.h>
#include <pliant/mesh_files.h>
#include <pliant/models/organs.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "commands.h"
#include "common_options.h"
#include "json.h"
#include "morph_points.h"
#include "output_names.h"
#include "output_text.h"
#include "progress.h"
#include "setting_options.h"
#include "standard_output.h"

namespace pliant::app {
namespace fs = std::filesystem;
namespace {

struct MorphInputs {
    std::optional<Volume> from, to, scan;
    std::vector<MorphModulus> moduli;
    std::optional<PointTable> known, asked;
    bool are_ras = false;  ///< the tables' points, as they were read
};

struct MorphOutputs {
    StagedFiles files;
    fs::path predicted, displacement, transform, jacobian, volume, report;
};

Error invalid_option(const std::string& message) {
    return {ErrorCode::InvalidArgument, message};
}

Status check_options(const MorphOptions& o) {
    if (!o.from.empty() && o.to.empty())
        return invalid_option("TO: expected a label map of the other phase, found none");
    if (o.from.empty() && o.points.empty())
        return invalid_option(
            "FROM TO or --points: expected label maps, points or both, found "
            "neither");
    if (o.predict.empty() != o.out.empty())
        return invalid_option(o.out.empty() ? "--out: expected a name for the points of --predict, "
                                              "found none"
                                            : "--predict: expected the points to move, found none");
    if (o.out.empty() && o.displacement.empty() && o.transform.empty() && o.jacobian.empty() &&
        o.volume.empty() && o.report.empty())
        return invalid_option("--out: expected --predict and --out, or another output, found none");
    if (!o.volume.empty() && o.scan.empty())
        return invalid_option("--volume: expected --scan, the scan to move, found none");
    return Ok{};
}

Status stage(const MorphOptions& o, MorphOutputs& outputs) {
    const std::vector<std::string> fields{".nrrd", ".nhdr", ".nii", ".nii.gz"};
    const OutputName names[] = {
        {"--out", o.out, outputs.predicted},
        {"--displacement", o.displacement, outputs.displacement, fields},
        {"--transform", o.transform, outputs.transform, fields},
        {"--jacobian", o.jacobian, outputs.jacobian, scan_endings()},
        {"--volume", o.volume, outputs.volume, scan_endings()},
        {"--report", o.report, outputs.report},
    };
    std::error_code error;
    for (const std::string& input : {o.to, o.points, o.predict, o.scan})
        for (const OutputName& name : names)
            if (!input.empty() && !name.name.empty() &&
                fs::weakly_canonical(name.name, error) == fs::weakly_canonical(input, error))
                return invalid_option(std::string(name.option) +
                                      ": expected a file of its own, found " + name.name +
                                      ", which is an input");
    return stage_names(names, o.from, outputs.files);
}

/// Share of points that lie in a label.
double share_inside(const Volume& labels, const std::vector<Vec3d>& points, double sign) {
    int inside = 0;
    for (const Vec3d& p : points) {
        const Vec3d at = voxel_from_world(labels.grid, {sign * p.x, sign * p.y, p.z});
        Vec3i voxel{0, 0, 0};
        bool is_in = true;
        for (int a = 0; a < 3; ++a) {
            is_in &= at[a] > -0.5 && at[a] < labels.grid.size[a] - 0.5;
            if (is_in) voxel[a] = int(std::lround(at[a]));
        }
        inside += is_in && labels.at(voxel) > 0;
    }
    return points.empty() ? 0 : inside / double(points.size());
}

void to_lps(std::vector<Vec3d>& points) {
    for (Vec3d& p : points) p = {-p.x, -p.y, p.z};
}

/// Turns the tables' points into LPS. @returns a note; empty if there is nothing to tell
std::string turn_points(const MorphOptions& o, MorphInputs& in) {
    std::vector<Vec3d> all;
    for (const auto* table : {&in.known, &in.asked})
        if (*table) all.insert(all.end(), (*table)->from_mm.begin(), (*table)->from_mm.end());
    std::string note;
    if (o.axes == "auto" && in.from && !all.empty()) {
        const double lps = share_inside(*in.from, all, 1), ras = share_inside(*in.from, all, -1);
        in.are_ras = ras >= 0.5 && lps < 0.5 * ras;
        if (in.are_ras)
            note = "points taken as RAS, in which " + fixed_text(100 * ras, 0) +
                   " % lie in FROM (as LPS " + fixed_text(100 * lps, 0) + " %); --axes says it";
        else if (lps < 0.5)
            note = "only " + fixed_text(100 * lps, 0) + " % of the points lie in FROM";
    }
    if (o.axes == "ras") in.are_ras = true;
    if (in.are_ras)
        for (auto* table : {&in.known, &in.asked})
            if (*table) {
                to_lps((*table)->from_mm);
                to_lps((*table)->to_mm);
            }
    return note;
}

Result<MorphModulus> modulus_from(const std::string& text) {
    MorphModulus modulus;
    const char *at = text.data(), *const end = at + text.size();
    auto read = std::from_chars(at, end, modulus.label);
    const bool has_label = read.ec == std::errc() && read.ptr != end && *read.ptr == '=';
    if (has_label) read = std::from_chars(read.ptr + 1, end, modulus.relative);
    if (!has_label || read.ec != std::errc() || read.ptr != end)
        return invalid_option("--moduli: expected LABEL=RATIO, such as 7=20, found '" + text + "'");
    return modulus;
}

/// A label map, or the inside of a closed surface.
Result<Volume> read_shape(const std::string& name) {
    if (!is_mesh_file(name)) return read_labels(name);
    auto surface = read_surface(name);
    if (!surface.ok()) return surface.error();
    auto labels = labels_of_surface(*surface);
    if (!labels.ok()) return renamed(labels.error(), name);
    return labels;
}

Status read_inputs(const MorphOptions& o, MorphInputs& in, const TaskArena& arena) {
    for (const std::string& text : o.moduli) {
        const auto modulus = modulus_from(text);
        if (!modulus.ok()) return modulus.error();
        in.moduli.push_back(*modulus);
    }
    if (!o.points.empty()) {
        auto table = read_point_table(o.points, true);
        if (!table.ok()) return table.error();
        in.known = std::move(*table);
    }
    if (!o.predict.empty()) {
        auto table = read_point_table(o.predict, false);
        if (!table.ok()) return table.error();
        in.asked = std::move(*table);
    }
    const std::pair<const std::string*, std::optional<Volume>*> volumes[] = {
        {&o.from, &in.from}, {&o.to, &in.to}, {&o.scan, &in.scan}};
    std::vector<Status> read(std::size(volumes), Ok{});
    arena.for_each(std::int64_t(read.size()), 1, [&](std::int64_t begin, std::int64_t end) {
        for (; begin < end; ++begin) {
            const auto& [name, to] = volumes[begin];
            if (name->empty()) continue;
            auto volume = to == &in.scan ? read_volume(*name) : read_shape(*name);
            if (volume.ok())
                *to = std::move(*volume);
            else
                read[std::size_t(begin)] = volume.error();
        }
    });
    for (const Status& status : read)
        if (!status.ok()) return status.error();
    return Ok{};
}

/// An error of the library under the names of the command line.
Error named(const MorphOptions& o, const Error& error) {
    if (error.field == "moduli") return renamed(error, "--moduli");
    if (error.field == "from") return renamed(error, o.from);
    if (error.field == "to") return renamed(error, o.to);
    if (error.field == "from_mm" || error.field == "to_mm")
        return renamed(error, o.points.empty() ? o.to : o.points);
    return named_by_option(error);
}

Json report_json(const MorphReport& r, const Morph& morph, const MorphInputs& in) {
    const Grid& nodes = morph.nodes();
    Json json = {{"version", PLIANT_VERSION},
                 {"points", r.points},
                 {"parts", r.parts},
                 {"prior", r.has_prior ? "supine" : "none"}};
    if (in.known || in.asked) json["axes"] = in.are_ras ? "ras" : "lps";
    json["point_residual_mm"] = r.point_residual_mm;
    json["surface_residual_mm"] = r.surface_residual_mm;
    json["max_displacement_mm"] = r.max_displacement_mm;
    json["least_volume"] = r.least_volume;
    json["folded_cells"] = 0;
    json["softened"] = r.softened;
    json["affine_share"] = r.affine_share;
    json["nodes"] = {nodes.size.x, nodes.size.y, nodes.size.z};
    json["node_spacing_mm"] = {nodes.spacing_mm.x, nodes.spacing_mm.y, nodes.spacing_mm.z};
    json["solve_ms"] = r.solve_ms;
    return json;
}

Status write_fields(const MorphOptions& o, const MorphInputs& in, const Morph& morph,
                    const MorphOutputs& outputs, const TaskArena& arena) {
    const Encoding encoding = o.raw ? Encoding::Raw : Encoding::Gzip;
    const Grid& rest = in.scan ? in.scan->grid : in.from ? in.from->grid : morph.nodes();
    const Grid& moved = in.scan ? in.scan->grid : in.to ? in.to->grid : morph.nodes();
    if (!outputs.displacement.empty() || !outputs.jacobian.empty()) {
        const auto field = morph.forward_field(rest, arena);
        if (!field.ok()) return field.error();
        if (!outputs.displacement.empty())
            if (const Status s = write_vector_field(outputs.displacement, *field, encoding); !s)
                return s;
        if (!outputs.jacobian.empty()) {
            const auto jacobian = jacobian_field(*field);
            if (!jacobian.ok()) return jacobian.error();
            if (const Status s = write_volume(outputs.jacobian, *jacobian, encoding); !s) return s;
        }
    }
    if (!outputs.transform.empty() || !outputs.volume.empty()) {
        const auto field = morph.inverse_field(moved, arena);
        if (!field.ok()) return field.error();
        if (!outputs.transform.empty())
            if (const Status s = write_vector_field(outputs.transform, *field, encoding); !s)
                return s;
        if (!outputs.volume.empty()) {
            const auto volume = apply_field(*field, *in.scan, arena);
            if (!volume.ok()) return volume.error();
            if (const Status s = write_volume(outputs.volume, *volume, encoding); !s) return s;
        }
    }
    return Ok{};
}

Status write_outputs(const MorphOptions& o, const MorphInputs& in, const Morph& morph,
                     MorphOutputs& outputs, const TaskArena& arena) {
    if (!outputs.predicted.empty()) {
        std::vector<Vec3d> to_mm;
        for (const Vec3d& p : in.asked->from_mm) to_mm.push_back(morph.forward(p));
        if (in.are_ras) to_lps(to_mm);
        if (const Status s = write_text(outputs.predicted, predicted_text(*in.asked, to_mm)); !s)
            return s;
    }
    if (const Status s = write_fields(o, in, morph, outputs, arena); !s) return s;
    if (!outputs.report.empty())
        if (const Status s =
                write_text(outputs.report, report_json(morph.report(), morph, in).dump(2) + "\n");
            !s)
            return s;
    return outputs.files.commit();
}

void print_summary(const MorphReport& r, const std::string& note) {
    std::string line;
    if (r.parts)
        line += std::to_string(r.parts) + (r.parts == 1 ? " part" : " parts") +
                (r.has_prior ? " with the prior of lungs" : "") + ", surface within " +
                short_text(r.surface_residual_mm, 3) + " mm; ";
    if (r.points)
        line += std::to_string(r.points) + (r.points == 1 ? " point" : " points") + " met to " +
                short_text(r.point_residual_mm, 3) + " mm; ";
    std::printf("%smoves by up to %s mm, no fold (at least %s of the volume is left); %s ms\n",
                line.c_str(), short_text(r.max_displacement_mm, 3).c_str(),
                short_text(r.least_volume, 2).c_str(), fixed_text(r.solve_ms, 0).c_str());
    if (r.softened || r.affine_share > 0)
        std::printf("would have folded: softened in %d rounds%s\n", r.softened,
                    r.affine_share > 0 ? (", drawn to its affine part by " +
                                          fixed_text(100 * r.affine_share, 0) + " %")
                                             .c_str()
                                       : "");
    if (!note.empty()) std::printf("%s\n", note.c_str());
}

}  // namespace

void add_morph(CLI::App& app, MorphOptions& o) {
    auto* c = app.add_subcommand(
        "morph", "Motion of an organ between two phases, from its shapes and known points");
    c->add_option("FROM", o.from,
                  "label map of the organ at the first phase, or a closed surface (VTP, STL, OBJ, "
                  "PLY, VTK)");
    c->add_option("TO", o.to, "the same at the second phase, on any grid");
    c->add_option("--moduli", o.moduli,
                  "Young's moduli of labels of FROM over that of the others: 7=20,8=0.5. A label "
                  "that TO lacks, such as a tumour, is tissue of the part around it")
        ->delimiter(',');
    c->add_option("--points", o.points,
                  "known points: CSV with the columns from_x_mm, from_y_mm, from_z_mm, to_x_mm, "
                  "to_y_mm, to_z_mm");
    c->add_option("--predict", o.predict,
                  "points to move: CSV with the columns from_x_mm, from_y_mm, from_z_mm");
    c->add_option("--out", o.out,
                  "the points of --predict with the columns to_x_mm, to_y_mm, to_z_mm");
    c->add_option("--axes", o.axes,
                  "of the tables: lps, ras, or auto: LPS, unless only as RAS most points lie in "
                  "FROM (default auto)")
        ->check(CLI::IsMember({"auto", "lps", "ras"}));
    c->add_option("--scan", o.scan, "scan at the first phase: its grid is that of the fields");
    c->add_option("--volume", o.volume, "the scan moved to the second phase");
    c->add_option("--displacement", o.displacement,
                  "field from FROM to TO at the voxels of --scan or FROM [mm, LPS]");
    c->add_option("--transform", o.transform,
                  "its inverse at the voxels of --scan or TO, as resampling filters expect");
    c->add_option("--jacobian", o.jacobian, "local growth of the volume, det (I + du/dX)");
    c->add_option("--report", o.report, "residuals, bound of the volume, times as JSON");
    for (const auto& row : morph_rows()) add_setting(c, morph_rows(), row.name, o.given);
    c->add_flag("--raw", o.raw, "no compression of volumes and fields: faster, larger");
    add_threads(c, o.threads);
    c->footer(
        "Examples:\n"
        "  pliant morph exhale.nii.gz inhale.nii.gz --predict nodules.csv --out moved.csv\n"
        "  pliant morph exhale.nii.gz inhale.nii.gz --points known.csv --transform t.nrrd\n"
        "  pliant morph --points known.csv --scan ct.nrrd --volume moved.nrrd\n"
        "  pliant morph liver_out.stl liver_in.stl --scan ct.nrrd --volume moved.nrrd\n"
        "docs/howto/morph.md describes the method and its errors on measured lungs.");
}

int run_morph(const MorphOptions& o) {
    if (const Status s = check_options(o); !s.ok()) return bad_input(s.error());
    MorphSettings settings;
    if (const Status s = apply(o.given, morph_rows(), settings); !s.ok())
        return bad_input(named_by_option(s.error()).message);
    MorphOutputs outputs;
    if (const Status s = stage(o, outputs); !s.ok()) return bad_input(s.error());
    std::optional<ProgressBar> bar(std::in_place, "morph");
    const auto fail = [&](const Error& error) {
        bar.reset();
        return bad_input(error.message);
    };
    const TaskArena arena(o.threads);
    MorphInputs in;
    if (const Status s = read_inputs(o, in, arena); !s.ok()) return fail(s.error());
    const std::string note = turn_points(o, in);
    bar->show(0.2);
    MorphInput input;
    if (in.known) {
        input.from_mm = in.known->from_mm;
        input.to_mm = in.known->to_mm;
    }
    if (in.from) {
        input.from = &*in.from;
        input.to = &*in.to;
    }
    input.moduli = in.moduli;
    if (in.scan) input.grid = &in.scan->grid;
    const auto morph = Morph::create(input, settings, arena);
    if (!morph.ok()) return fail(named(o, morph.error()));
    bar->show(0.6);
    if (const Status s = write_outputs(o, in, *morph, outputs, arena); !s.ok())
        return fail(s.error());
    bar.reset();
    if (!is_standard_output(o.report) && !is_standard_output(o.out))
        print_summary(morph->report(), note);
    return kExitOk;
}

}  // namespace pliant::app
