// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "session/replay.h"

#include <pliant/data/session.h>

#include "base/errors.h"
#include "protocol/messages.h"
#include "session/checkpoint.h"

namespace pliant::serve {
namespace {

Status compare_with(Scene& scene, const SessionMark& mark, Compare compare, std::size_t number) {
    if (compare == Compare::Nothing) return Ok{};
    std::uint64_t volume = mark.volume;
    if (compare == Compare::All) {
        if (const auto update = scene.update(); !update) return update.error();
        volume = hash_volume(scene.deformed());
    }
    const std::uint64_t tissue = scene.tissue().hash();
    if (volume == mark.volume && tissue == mark.tissue) return Ok{};
    return Error{ErrorCode::Unreadable,
                 "record " + std::to_string(number) + ": expected the volume " +
                     hex_text(mark.volume, 16) + " and the tissue " + hex_text(mark.tissue, 16) +
                     ", found " + hex_text(volume, 16) + " and " + hex_text(tissue, 16)};
}

Status pass(Scene& scene, const SessionCheckpoint& point, Compare compare, std::size_t number) {
    if (scene.is_quiet()) {
        const Result<SceneMemo> memo = scene.rest();
        if (!memo.ok()) return memo.error();
        SceneMemo expected = point.memo;
        // Older files don't record the vessel; the tissue's hash proves it.
        if (expected.tissue == TissueChoice{} && memo->tissue.model == "vessel")
            expected.tissue.model = "vessel";
        if (*memo == expected) return compare_with(scene, point.mark, compare, number);
    }
    return Error{ErrorCode::Unreadable, "record " + std::to_string(number) +
                                            ": expected the scene of checkpoint " +
                                            std::to_string(point.number) + ", found another one"};
}

}  // namespace

Result<double> sweep_recorded(Scene& scene, const SessionSweeps& sweeps) {
    double ms = 0;
    for (int n = 0; n < sweeps.count + (sweeps.parts ? 1 : 0); ++n) {
        SweepLimit limit;
        if (n == sweeps.count) limit.max_parts = *sweeps.parts;
        const Result<Sweep> swept = scene.sweep(limit);
        if (!swept.ok()) return swept.error();
        ms += swept->ms;
    }
    return ms;
}

Status load_recorded(Scene& scene, const SessionState& state) {
    const auto checksum = checksum_of(state.file);
    if (checksum && *checksum != state.checksum)
        return Error{ErrorCode::Unreadable, state.file + ": expected the state " +
                                                hex_text(state.checksum, 16) + ", found " +
                                                hex_text(*checksum, 16)};
    return scene.load_state(state.file);
}

Status replay_into(Scene& scene, std::span<const SessionRecord> records, Compare compare,
                   const Progress& progress, std::size_t before) {
    for (std::size_t n = 0; n < records.size(); ++n) {
        if (progress) progress(double(n) / double(records.size()));
        if (const auto* command = std::get_if<SessionCommand>(&records[n])) {
            const auto outcome = attempt([&]() -> Result<Outcome> {
                return scene.carry_out(command->client, command->action);
            });
            if (!outcome.ok()) return outcome.error();
            if (outcome->ok() == command->refused)
                return Error{ErrorCode::Unreadable,
                             "record " + std::to_string(before + n + 1) +
                                 ": expected a command that is " +
                                 (command->refused ? "refused" : "carried out") +
                                 ", found the opposite: " + outcome->message};
        } else if (const auto* sweeps = std::get_if<SessionSweeps>(&records[n])) {
            if (const auto swept = sweep_recorded(scene, *sweeps); !swept.ok())
                return swept.error();
        } else if (const auto* mark = std::get_if<SessionMark>(&records[n])) {
            const Status s = compare_with(scene, *mark, compare, before + n + 1);
            if (!s.ok()) return s;
        } else if (const auto* point = std::get_if<SessionCheckpoint>(&records[n])) {
            const Status s = pass(scene, *point, compare, before + n + 1);
            if (!s.ok()) return s;
        } else if (const auto* forget = std::get_if<SessionForget>(&records[n])) {
            scene.forget_steps(forget->steps);
        } else if (const auto* broken = std::get_if<SessionBreak>(&records[n])) {
            scene.interrupt(broken->client);
        } else if (const auto* lost = std::get_if<SessionLost>(&records[n])) {
            scene.lose_steps(lost->steps);
        } else if (const auto* state = std::get_if<SessionState>(&records[n])) {
            const Status s = load_recorded(scene, *state);
            if (!s.ok())
                return Error{s.error().code,
                             "record " + std::to_string(before + n + 1) + ": " + s.error().message};
        }
    }
    return Ok{};
}

namespace {

/// Replays a whole session, scene by scene. @returns the last scene
Result<std::unique_ptr<Scene>> replay_all(const SessionFile& file, const TaskArena& arena,
                                          const Progress& progress) {
    const std::span<const SessionRecord> all(file.records);
    const SessionHeader* next = &file.header;
    for (std::size_t begin = 0;;) {
        auto scene = open_recorded(*next, arena);
        if (!scene.ok()) return scene.error();
        std::size_t end = begin;
        while (end < all.size() && !std::holds_alternative<SessionOpen>(all[end])) ++end;
        const auto share = [&](double fraction) {
            if (progress)
                progress((double(begin) + fraction * double(end - begin)) / double(all.size()));
        };
        const Status status =
            replay_into(**scene, all.subspan(begin, end - begin), Compare::All, share, begin);
        if (!status.ok()) return status.error();
        if (end == all.size()) return std::move(*scene);
        next = &std::get_if<SessionOpen>(&all[end])->scan;
        begin = end + 1;
    }
}

ValueDefaults last_values(const Scene& scene) {
    ValueDefaults values = scene.info().values;
    SharedState state;
    scene.describe(state);
    values.iso = state.iso_hu;
    values.lumen_is_bright = state.polarity == Polarity::Falling;
    return values;
}

}  // namespace

}  // namespace pliant::serve

namespace pliant {

Result<ReplayReport> replay_session(const std::filesystem::path& path, const TaskArena& arena,
                                    const ReplaySettings& settings) {
    const auto named = [&](const Error& error) {
        return Error{error.code, path.string() + ": " + error.message};
    };
    auto file = serve::read_session(path);
    if (!file.ok()) return file.error();
    if (settings.own_tissue)
        file->use_tissue(std::make_shared<const MakeTissue>(settings.own_tissue));
    ReplayReport report;
    std::unique_ptr<serve::Scene> scene;
    if (settings.from_checkpoint) {
        auto reopened = serve::reopen(*file, path, arena);
        if (!reopened.ok()) return named(reopened.error());
        scene = std::move(reopened->scene);
        report.from_checkpoint = reopened->number;
    } else {
        auto replayed = serve::replay_all(*file, arena, settings.progress);
        if (!replayed.ok()) return named(replayed.error());
        scene = std::move(*replayed);
    }
    if (const auto update = scene->update(); !update) return named(update.error());
    report.cut_off_bytes = file->cut_off_bytes;
    for (const auto& record : file->records) {
        report.commands += std::holds_alternative<serve::SessionCommand>(record);
        report.marks += std::holds_alternative<serve::SessionMark>(record) ||
                        std::holds_alternative<serve::SessionCheckpoint>(record);
    }
    report.volume_hash = hash_volume(scene->deformed());
    report.tissue_hash = scene->tissue().hash();
    if (settings.finish) {
        const Status s = settings.finish(scene->tissue(), serve::last_values(*scene));
        if (!s.ok()) return s.error();
    }
    return report;
}

}  // namespace pliant
