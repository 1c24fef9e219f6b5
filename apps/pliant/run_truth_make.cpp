// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Makes cases of registration truth. Each case appears with its index, as a whole: a run that is
// interrupted leaves a data set with the cases before.

#include <pliant/core/files.h>
#include <pliant/core/version.h>
#include <pliant/data/truth.h>
#include <pliant/scan_files.h>
#include <pliant/tissues.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "options.h"
#include "output_text.h"
#include "progress.h"
#include "scan_defaults.h"
#include "setting_options.h"
#include "truth_files.h"

namespace pliant::app {
namespace fs = std::filesystem;
namespace {

std::string case_name(int n) {
    char text[32];
    std::snprintf(text, sizeof text, "case_%04d", n);
    return text;
}

/// @returns InvalidArgument unless it is missing or empty
Status check_folder(const fs::path& out) {
    std::error_code error;
    const auto type = fs::status(out, error).type();
    if (type == fs::file_type::not_found) return Ok{};
    if (type == fs::file_type::directory && fs::is_empty(out, error)) return Ok{};
    return Error{ErrorCode::InvalidArgument, "--out: expected a new or an empty folder, found " +
                                                 out.string() +
                                                 (error ? " (" + error.message() + ")" : "")};
}

Result<ChainMailSettings> chainmail_of(const std::string& config, const ValueDefaults& values) {
    if (!config.empty()) return read_chainmail_settings(config, values);
    ChainMailSettings settings;
    suit_materials(values, settings);
    return settings;
}

Result<ScanTissueSettings> materials_of(const TruthMakeOptions& o, const ValueDefaults& values) {
    if (o.model == "elastic") {
        auto settings = elastic_settings(o.config, o.tissue, values);
        if (!settings.ok()) return settings.error();
        return ScanTissueSettings(std::move(*settings));
    }
    if (!o.tissue.empty())
        return Error{
            ErrorCode::InvalidArgument,
            option_of(o.tissue.front().name) + ": expected --model elastic too, found " + o.model};
    auto settings = chainmail_of(o.config, values);
    if (!settings.ok()) return settings.error();
    return ScanTissueSettings(std::move(*settings));
}

}  // namespace

int run_truth_make(const TruthMakeOptions& o) {
    const auto begin = std::chrono::steady_clock::now();
    TruthSettings settings;
    if (const Status s = apply(o.given, truth_rows(), settings); !s.ok())
        return bad_input(named_by_option(s.error()).message);
    const fs::path out = o.out;
    if (const Status s = check_folder(out); !s.ok()) return bad_input(s.error());
    std::optional<ProgressBar> bar(std::in_place, "truth");
    const auto fail = [&](const Error& error) {
        bar.reset();
        return bad_input(named_by_option(error).message);
    };
    const TaskArena arena(o.threads);
    ReadNotes notes;
    auto scan = read_volume(o.file, o.scan.options(), &notes);
    if (!scan.ok()) return fail(scan.error());
    const ValueDefaults values = take_values(*scan, notes);
    const auto materials = materials_of(o, values);
    if (!materials.ok()) return fail(materials.error());
    const auto maker = TruthMaker::create(*scan, *materials, settings, arena);
    if (!maker.ok()) return fail(maker.error());
    const std::string ending = o.format == "nrrd" ? ".nrrd" : ".nii.gz";
    const Encoding encoding = o.raw ? Encoding::Raw : Encoding::Gzip;
    Json index = {{"pliant_truth", 1},
                  {"version", PLIANT_VERSION},
                  {"scan", fs::path(o.file).filename().string()},
                  {"format", o.format},
                  {"seed", o.seed},
                  {"fixed", "fixed" + ending},
                  {"cases", Json::array()}};
    double worst = 0;
    for (int n = 0; n < o.cases; ++n) {
        const auto made = maker->make(o.seed + std::uint64_t(n));
        if (!made.ok()) return fail(made.error());
        worst = std::max({worst, made->inverse_error_mm, made->landmark_error_mm});
        const Json record = truth_record(*made, o.model, settings);
        const std::string name = case_name(n);
        index["cases"].push_back(
            {{"folder", name}, {"seed", made->seed}, {"hash", record["hash"]}});
        std::error_code error;
        fs::create_directories(out, error);
        if (error)
            return fail({ErrorCode::Unwritable,
                         "--out: can't make the folder " + out.string() + ": " + error.message()});
        StagedFiles files;
        const auto folder = files.stage_folder(out / name);
        if (!folder.ok()) return fail(folder.error());
        if (const Status s = write_truth_case(*made, record, *folder, ending, encoding, arena);
            !s.ok())
            return fail(s.error());
        if (n == 0) {
            const auto fixed = files.stage(out / ("fixed" + ending));
            if (!fixed.ok()) return fail(fixed.error());
            if (const Status s = write_volume(*fixed, *scan, encoding); !s.ok())
                return fail(s.error());
        }
        const auto list = files.stage(out / "truth.json");
        if (!list.ok()) return fail(list.error());
        if (const Status s = write_text(*list, index.dump(2) + "\n"); !s.ok())
            return fail(s.error());
        if (const Status s = files.commit(); !s.ok()) return fail(s.error());
        bar->show(double(n + 1) / o.cases);
    }
    bar.reset();
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::printf("%s: %d cases in %.1f s (%.2f s each); forward and inverse agree to %.1e mm\n",
                printable(o.out, 300).c_str(), o.cases, seconds, seconds / o.cases, worst);
    return kExitOk;
}

}  // namespace pliant::app
