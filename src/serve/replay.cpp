// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "serve/replay.h"

#include <pliant/serve.h>

#include "serve/messages.h"

namespace pliant::serve {
namespace {

Status compare(Scene& scene, const SessionMark& mark, std::size_t number) {
    scene.update();
    const std::uint64_t volume = hash_volume(scene.deformed()), tissue = scene.tissue().hash();
    if (volume == mark.volume && tissue == mark.tissue) return Ok{};
    return Error{ErrorCode::Unreadable,
                 "record " + std::to_string(number) + ": expected the volume " +
                     hex_text(mark.volume, 16) + " and the tissue " + hex_text(mark.tissue, 16) +
                     ", found " + hex_text(volume, 16) + " and " + hex_text(tissue, 16)};
}

}  // namespace

Result<std::unique_ptr<Scene>> open_recorded(const SessionHeader& header, const TaskArena& arena) {
    auto scene = Scene::open(header.source, arena);
    if (scene.ok() && (*scene)->scan_hash() != header.scan_hash)
        return Error{ErrorCode::InvalidArgument,
                     "expected the scan " + hex_text(header.scan_hash, 16) +
                         ", found another one: " + (*scene)->info().name};
    return scene;
}

Status replay_into(Scene& scene, std::span<const SessionRecord> records, bool compare_marks,
                   const Progress& progress, std::size_t before) {
    for (std::size_t n = 0; n < records.size(); ++n) {
        if (progress) progress(double(n) / double(records.size()));
        if (const auto* command = std::get_if<SessionCommand>(&records[n])) {
            const Outcome outcome = scene.carry_out(command->client, command->action);
            if (outcome.ok() == command->refused)
                return Error{ErrorCode::Unreadable,
                             "record " + std::to_string(before + n + 1) +
                                 ": expected a command that is " +
                                 (command->refused ? "refused" : "carried out") +
                                 ", found the opposite: " + outcome.message};
        } else if (const auto* sweeps = std::get_if<SessionSweeps>(&records[n])) {
            for (int k = 0; k < sweeps->count; ++k) scene.sweep();
        } else if (const auto* mark = std::get_if<SessionMark>(&records[n])) {
            if (!compare_marks) continue;
            if (const Status s = compare(scene, *mark, before + n + 1); !s.ok()) return s;
        }
    }
    return Ok{};
}

}  // namespace pliant::serve

namespace pliant {

Result<ReplayReport> replay_session(const std::filesystem::path& path, const TaskArena& arena,
                                    const Progress& progress) {
    const auto named = [&](const Error& error) {
        return Error{error.code, path.string() + ": " + error.message};
    };
    const auto file = serve::read_session(path);
    if (!file.ok()) return file.error();
    const std::span<const serve::SessionRecord> all(file->records);
    std::unique_ptr<serve::Scene> scene;
    const serve::SessionHeader* next = &file->header;
    // Scene by scene; each begins where a scan was opened.
    for (std::size_t begin = 0; next;) {
        scene.reset();
        auto opened = serve::open_recorded(*next, arena);
        if (!opened.ok()) return named(opened.error());
        scene = std::move(*opened);
        std::size_t end = begin;
        while (end < all.size() && !std::holds_alternative<serve::SessionOpen>(all[end])) ++end;
        const auto share = [&](double fraction) {
            if (progress)
                progress((double(begin) + fraction * double(end - begin)) / double(all.size()));
        };
        const Status status =
            serve::replay_into(*scene, all.subspan(begin, end - begin), true, share, begin);
        if (!status.ok()) return named(status.error());
        next = end < all.size() ? &std::get_if<serve::SessionOpen>(&all[end])->scan : nullptr;
        begin = end + 1;
    }
    scene->update();
    ReplayReport report;
    report.cut_off_bytes = file->cut_off_bytes;
    for (const auto& record : file->records) {
        report.commands += std::holds_alternative<serve::SessionCommand>(record);
        report.marks += std::holds_alternative<serve::SessionMark>(record);
    }
    report.volume_hash = hash_volume(scene->deformed());
    report.tissue_hash = scene->tissue().hash();
    return report;
}

}  // namespace pliant
