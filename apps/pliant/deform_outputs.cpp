// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "deform_outputs.h"

#include <pliant/files.h>
#include <pliant/render.h>

#include <algorithm>
#include <fstream>

#include "look.h"
#include "output_names.h"
#include "scan_defaults.h"

namespace pliant::app {
namespace {

namespace fs = std::filesystem;

constexpr int kPictureSide = 800;  ///< pixels of each of the two four-ups

/// Draws before and after, with the same camera and the same sections through the pushed point.
Image before_and_after(const DeformOptions& o, const MovingScan& scan, const DeformResult& result,
                       const PushOption& push) {
    const Volume& after = result.deformed.volume;
    const Volume& before = scan.volume();
    const TaskArena& arena = scan.arena();
    const ValueDefaults& values = result.values;
    const double iso_hu = o.iso_hu.value_or(values.iso);
    const Polarity polarity = polarity_of(o.polarity, values);
    FourUp view;
    view.endoscope.polarity = polarity;
    view.section.window_hu = o.window_hu.value_or(values.window);
    view.section.level_hu = o.level_hu.value_or(values.level);
    if (o.eye_mm) {
        view.endoscope.eye_mm = *o.eye_mm;
        view.endoscope.look = o.look.value_or(push.point_mm - *o.eye_mm);
        // An eye in bright contrast agent looks at a darker wall.
        const Vec3d eye_ijk = voxel_from_world(before.grid, *o.eye_mm);
        if (!o.polarity && values.kind == ValueKind::Hounsfield &&
            sample_linear(before, eye_ijk) >= iso_hu)
            view.endoscope.polarity = Polarity::Falling;
    } else {
        view.endoscope =
            aim_endoscope(before, push.point_mm, push.push_mm, iso_hu, polarity, arena);
        if (o.look) view.endoscope.look = *o.look;
    }
    view.endoscope.iso_hu = iso_hu;
    set_look(o.look_of, view.endoscope);
    view.section.point_mm = push.point_mm;
    const double scale = length_scale(before.grid);
    view.endoscope.fog_distance_mm = scale * Endoscope{}.fog_distance_mm;
    // Zoom such that the push is at least a tenth of the picture.
    const double width_mm = before.grid.size.x * before.grid.spacing_mm.x;
    view.section.width_mm = std::min(width_mm, std::max(80 * scale, 10 * norm(push.push_mm)));
    view.caption = "before";
    const Image left = four_up_view(before, view, kPictureSide, kPictureSide, arena);
    // Most pages are shared with the other scan and would count twice.
    std::visit([](const auto& voxels) { voxels.let_go(); }, before.voxels);
    view.caption = "after";
    view.endoscope.rest = &result.rest;
    return side_by_side(left, four_up_view(after, view, kPictureSide, kPictureSide, arena));
}

Status write_text(const fs::path& path, const std::string& text) {
    std::ofstream stream(path, std::ios::binary);
    stream << text;
    stream.close();
    if (stream) return Ok{};
    return Error{ErrorCode::Unwritable, path.filename().string() + ": can't be written"};
}

}  // namespace

Status stage_outputs(const DeformOptions& o, Outputs& outputs) {
    const std::vector<std::string> scans = scan_endings();
    const OutputName names[] = {
        {"--out", o.out, outputs.out, scans},
        {"--displacement", o.displacement, outputs.displacement, {".nrrd", ".nhdr"}},
        {"--transform", o.transform, outputs.transform, {".nrrd", ".nhdr"}},
        {"--jacobian", o.jacobian, outputs.jacobian, scans},
        {"--strain", o.strain, outputs.strain, scans},
        {"--report", o.report, outputs.report},
        {"--png", o.png, outputs.png, {".png"}},
        {"--save-state", o.save_state, outputs.state, {".plst"}},
    };
    return stage_names(names, o.file, outputs.files);
}

namespace {

Error about(const fs::path& path, const Error& error) {
    return {error.code, path.string() + ": " + error.message};
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
                     const PushOption& place,
                     const std::function<Status(const fs::path&)>& save_state, Outputs& outputs,
                     ProgressBar& bar) {
    const Encoding encoding = o.raw ? Encoding::Raw : Encoding::Gzip;
    const Deformed& deformed = result.deformed;
    if (Status s =
            write_volume(outputs.out, result.single ? *result.single : deformed.volume, encoding);
        !s.ok())
        return s;
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
        const Image image = before_and_after(o, scan, result, place);
        if (Status s = write_png(outputs.png, image); !s.ok()) return s;
    }
    if (!outputs.state.empty())
        if (Status s = save_state(outputs.state); !s.ok()) return s;
    if (!outputs.report.empty())
        if (Status s = write_text(outputs.report, report_json(o, result)); !s.ok()) return s;
    return outputs.files.commit();
}

}  // namespace pliant::app
