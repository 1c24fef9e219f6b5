// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "deform_outputs.h"

#include <pliant/core/files.h>
#include <pliant/scan_files.h>
#include <pliant/view/png.h>

#include "output_names.h"
#include "output_text.h"
#include "picture.h"

namespace pliant::app {
namespace fs = std::filesystem;

Status stage_outputs(const DeformOptions& o, Outputs& outputs) {
    const std::vector<std::string> scans = scan_endings();
    const OutputName names[] = {
        {o.mesh_out.empty() ? "--out" : "--volume", o.out, outputs.out, scans},
        {"--labels-out", o.labels_out, outputs.labels, scans},
        {"--displacement", o.displacement, outputs.displacement, {".nrrd", ".nhdr"}},
        {"--transform", o.transform, outputs.transform, {".nrrd", ".nhdr"}},
        {"--jacobian", o.jacobian, outputs.jacobian, scans},
        {"--strain", o.strain, outputs.strain, scans},
        {"--report", o.report, outputs.report},
        {"--png", o.picture.png, outputs.png, {".png"}},
        {"--save-state", o.save_state, outputs.state, {".plst"}},
        {"--out", o.mesh_out, outputs.mesh, {".vtu"}},
    };
    return stage_names(names, o.file, outputs.files);
}

namespace {

Error about(const fs::path& path, const Error& error) {
    return {error.code, path.string() + ": " + error.message};
}

/// The tool of the last push or slide, if the picture shows it.
ShownTool shown_tool(const DeformOptions& o, const DeformResult& result) {
    ShownTool tool{.radius_mm = o.sphere_radius_mm};
    if (!o.picture.shows_tool) return tool;
    std::size_t pushes = 0, slides = 0;
    for (const DeformAction& action : o.actions) {
        if (const auto* push = std::get_if<PushOption>(&action)) {
            const PushReport& report = result.pushes[pushes++];
            tool.before_mm = push->point_mm;
            tool.after_mm = push->point_mm + report.step_fraction * push->push_mm;
        } else if (const auto* slide = std::get_if<SlideOption>(&action)) {
            tool.before_mm = slide->point_mm;
            tool.after_mm = result.slides[slides++].end_mm;
        }
    }
    if (o.release) tool.after_mm.reset();
    return tool;
}

/// Writes a volume that is computed on demand. @param path  empty: not requested
template <class Make>
Status write_made(const fs::path& path, Encoding encoding, const Make& make) {
    if (path.empty()) return Ok{};
    const Result<Volume> volume = make();
    if (!volume) return about(path, volume.error());
    return write_volume(path, *volume, encoding);
}

}  // namespace

Status write_outputs(const DeformOptions& o, const MovingScan& scan, const DeformResult& result,
                     const PushOption& place, const OwnOutputs& own, Outputs& outputs,
                     ProgressBar& bar) {
    const Encoding encoding = o.raw ? Encoding::Raw : Encoding::Gzip;
    const Deformed& deformed = result.deformed;
    if (!outputs.out.empty())
        if (Status s = write_volume(outputs.out, result.single ? *result.single : deformed.volume,
                                    encoding);
            !s.ok())
            return s;
    if (!outputs.labels.empty())
        if (Status s = write_volume(outputs.labels, result.labels, encoding); !s.ok()) return s;
    if (!outputs.mesh.empty())
        if (Status s = own.write_mesh(outputs.mesh); !s.ok()) return s;
    bar.show(0.6);
    if (!outputs.displacement.empty()) {
        const Result<FieldSlices> slices = displacement_slices(scan);
        if (!slices) return about(outputs.displacement, slices.error());
        Status s = write_vector_field(outputs.displacement, scan.volume().grid, FieldKind::Modeling,
                                      *slices, encoding);
        if (!s.ok()) return s;
    }
    bar.show(0.7);
    if (!outputs.transform.empty()) {
        Status s = write_vector_field(outputs.transform, deformed.volume.grid,
                                      FieldKind::Resampling, inverse_slices(deformed), encoding);
        if (!s.ok()) return s;
    }
    bar.show(0.8);
    if (Status s = write_made(outputs.jacobian, encoding, [&] { return jacobian_field(scan); }); !s)
        return s;
    if (Status s = write_made(outputs.strain, encoding, [&] { return strain_field(scan); }); !s)
        return s;
    if (!outputs.png.empty()) {
        const Image image = before_and_after(o.picture, scan, deformed.volume, result.rest,
                                             result.values, place, shown_tool(o, result));
        if (Status s = write_png(outputs.png, image); !s.ok()) return s;
    }
    if (!outputs.state.empty())
        if (Status s = own.save_state(outputs.state); !s.ok()) return s;
    if (!outputs.report.empty())
        if (Status s = write_text(outputs.report, report_json(o, result)); !s.ok()) return s;
    return outputs.files.commit();
}

}  // namespace pliant::app
