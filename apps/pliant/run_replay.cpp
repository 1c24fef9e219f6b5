// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// pliant replay: replays a recorded session; a different result is an error.

#include <pliant/core/files.h>
#include <pliant/data/session.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>
#include <pliant/view/png.h>

#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "options.h"
#include "output_names.h"
#include "picture.h"
#include "progress.h"

namespace pliant::app {

namespace {

namespace fs = std::filesystem;

struct ReplayOutputs {
    StagedFiles files;
    fs::path out, displacement, transform, state, png;
};

Status write_picture(const fs::path& path, const PictureOptions& options, const Tissue& tissue,
                     const Deformed& deformed, const ValueDefaults& values) {
    const PushOption place = middle_of_deformation(tissue);
    if (options.eye_mm && !options.look && norm(place.point_mm - *options.eye_mm) == 0)
        return Error{ErrorCode::InvalidArgument,
                     "--eye: expected a position outside of the middle of the deformation, or "
                     "--look too"};
    RestField rest;
    if (shows_rest(options)) {
        auto made = RestField::create(tissue, deformed);
        if (!made) return made.error();
        rest = std::move(*made);
    }
    return write_png(path, before_and_after(options, tissue, deformed.volume, rest, values, place));
}

Status write_outputs(const ReplayOutputs& outputs, const PictureOptions& picture,
                     const Tissue& tissue, const ValueDefaults& values) {
    if (!outputs.out.empty() || !outputs.transform.empty() || !outputs.png.empty()) {
        const auto deformed = deform_volume(tissue, Mapping::Cells,
                                            !outputs.transform.empty() || shows_rest(picture));
        if (!deformed) return deformed.error();
        if (!outputs.png.empty())
            if (Status s = write_picture(outputs.png, picture, tissue, *deformed, values); !s.ok())
                return s;
        if (!outputs.out.empty())
            if (Status s = write_volume(outputs.out, deformed->volume); !s.ok()) return s;
        if (!outputs.transform.empty()) {
            Status s = write_vector_field(outputs.transform, deformed->volume.grid,
                                          FieldKind::Resampling, inverse_slices(*deformed));
            if (!s.ok()) return s;
        }
    }
    if (!outputs.displacement.empty()) {
        const auto slices = displacement_slices(tissue);
        if (!slices) return slices.error();
        Status s = write_vector_field(outputs.displacement, tissue.volume().grid,
                                      FieldKind::Modeling, *slices);
        if (!s.ok()) return s;
    }
    return outputs.state.empty() ? Ok{} : tissue.save_state(outputs.state);
}

}  // namespace

int run_replay(const ReplayOptions& options) {
    ReplayOutputs outputs;
    const OutputName names[] = {
        {"--out", options.out, outputs.out, scan_endings()},
        {"--displacement", options.displacement, outputs.displacement, {".nrrd", ".nhdr"}},
        {"--transform", options.transform, outputs.transform, {".nrrd", ".nhdr"}},
        {"--save-state", options.save_state, outputs.state, {".plst"}},
        {"--png", options.picture.png, outputs.png, {".png"}},
    };
    if (const Status s = check_picture(options.picture); !s.ok())
        return bad_input(s.error().message);
    if (const Status s = stage_names(names, options.session, outputs.files); !s.ok())
        return bad_input(s.error().message);
    const TaskArena arena(options.threads);
    std::optional<ProgressBar> bar(std::in_place, "replay");
    const ReplaySettings settings{.from_checkpoint = options.from_checkpoint,
                                  .progress = [&](double fraction) { bar->show(0.9 * fraction); },
                                  .finish =
                                      [&](const Tissue& tissue, const ValueDefaults& values) {
                                          return write_outputs(outputs, options.picture, tissue,
                                                               values);
                                      }};
    const auto report = replay_session(options.session, arena, settings);
    bar.reset();
    if (!report.ok()) return bad_input(report.error().message);
    if (const Status s = outputs.files.commit(); !s.ok()) return bad_input(s.error().message);
    const char* format =
        options.json ? "{\"from_checkpoint\": %d, \"commands\": %" PRId64 ", \"marks\": %" PRId64
                       ", \"cut_off_bytes\": %" PRIu64 ", \"volume_hash\": \"%016" PRIx64
                       "\", \"tissue_hash\": \"%016" PRIx64 "\"}\n"
                     : "from checkpoint %d (0: the start)\n%" PRId64 " commands, %" PRId64
                       " marks met, %" PRIu64 " bytes cut off\nvolume %016" PRIx64
                       "\ntissue %016" PRIx64 "\n";
    std::printf(format, report->from_checkpoint, report->commands, report->marks,
                report->cut_off_bytes, report->volume_hash, report->tissue_hash);
    return kExitOk;
}

}  // namespace pliant::app
