// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Seeds: sessions of the server, with marks and a checkpoint, made by the library as the server
// does.

#include <pliant/serve.h>

#include <cstdio>
#include <cstdlib>

#include "mutate/formats.h"
#include "mutate/repair.h"
#include "session/checkpoint.h"
#include "session/replay.h"
#include "session/session_log.h"
#include "support/temporary_folder.h"

namespace pliant::mutate {
namespace {

using namespace serve;

const SceneSource kCube{.phantom = "cube", .phantom_size = {8, 8, 8}};

const std::string kPush = R"({"client":1,"do":"push","point":[0,0,0],"push":[0,6,0],"radius":20})",
                  kRelease = R"({"client":1,"do":"release"})",
                  kRest = R"({"client":1,"do":"relax","on":false})";

const std::vector<std::string> kSpringCommands = {
    R"({"client":1,"do":"tissue","model":"springs","nodes":4,"cell_mm":20,"fixed_hu":3000})", kPush,
    R"({"client":1,"do":"depth","layers":3})", kRelease};

const std::vector<std::string> kCommands = {
    R"({"client":1,"do":"materials","bone_threshold_hu":3000})",
    kPush,
    R"({"client":1,"do":"grab","point":[10,0,0],"radius":15})",
    R"({"client":1,"do":"drag","offset":[0,2,0]})",
    R"({"client":1,"do":"let_go"})",
    R"({"client":1,"do":"cut","line":[[-50,-5,0.3],[50,-5,0.3]],"depth":[0,10,0]})",
    R"({"client":1,"do":"carve","from":[8,0,0],"to":[8,0,3],"radius":12,"stroke":1})",
    R"({"client":1,"do":"undo"})",
    R"({"client":1,"do":"iso","iso_hu":-391.5,"polarity":"falling"})",
    kRelease};

const std::string kStop = R"({"client":1,"do":"catheter","insert_mm_s":0,"rotate_deg_s":0})",
                  kManySweeps = R"({"do":"sweep","count":2000})";

const std::vector<std::string> kCatheterCommands = {
    R"({"client":1,"do":"catheter","insert_mm_s":50,"rotate_deg_s":30,"bend_first_deg":20})",
    R"({"do":"sweep","count":3})",
    kStop,
    R"({"do":"sweep","count":2})",
    R"({"client":1,"do":"undo"})",
    R"({"client":1,"do":"catheter","insert_mm_s":-20,"bend_second_deg":5})",
    R"({"do":"sweep","count":2})",
    kRelease};

template <class T>
T checked(Result<T> made) {
    if (!made.ok()) {
        std::fprintf(stderr, "mutate: can't make a session: %s\n", made.error().message.c_str());
        std::exit(2);
    }
    return std::move(*made);
}

void check(const Status& status) {
    if (!status.ok()) checked<int>(status.error());
}

struct Recorder {
    TaskArena arena{1};
    SceneSource source;  ///< as the session names it
    std::unique_ptr<Scene> scene;
    std::vector<SessionRecord> records;

    /// @param folder  of the files that the source names
    Recorder(SceneSource named, const std::filesystem::path& folder) : source(std::move(named)) {
        SceneSource opened = source;
        if (!opened.file.empty()) opened.file = (folder / opened.file).string();
        scene = checked(Scene::open(opened, arena));
    }
    /// A command, or sweeps as far as there are any.
    void act(const std::string& text) {
        SessionRecord record = checked(parse_session_record(text));
        if (auto* sweeps = std::get_if<SessionSweeps>(&record)) {
            int count = 0;
            for (; count < sweeps->count && scene->wants_sweep(); ++count) (void)scene->sweep();
            sweeps->count = count;
            if (count == 0) return;
        } else {
            auto& command = std::get<SessionCommand>(record);
            command.refused = !scene->carry_out(command.client, command.action).ok();
        }
        records.push_back(std::move(record));
    }
    void mark() {
        (void)scene->update();
        records.push_back(SessionMark{hash_volume(scene->deformed()), scene->tissue().hash()});
    }
    Files files(const std::filesystem::path& session) const {
        auto log = checked(SessionLog::create(session, {source, scene->scan_hash()}));
        for (const SessionRecord& record : records) log->add(record);
        check(log->flush());
        Files all{{.name = "s.pls", .bytes = test::bytes_of(session)}};
        for (int n = 1; n <= 2; ++n) {
            const auto path = checkpoint_path(session, n);
            if (std::filesystem::exists(path))
                all.push_back({.name = path.filename().string(), .bytes = test::bytes_of(path)});
        }
        return all;
    }
};

/// Commands before a checkpoint, commands that bring the scene to rest, and commands after it.
struct Doings {
    SceneSource source;
    Files files;  ///< that the source names
    std::vector<std::string> commands, rest, after;
};

Files session_files(const Doings& doings, bool with_marks, bool with_checkpoints) {
    const test::TemporaryFolder folder;
    for (const File& file : doings.files) folder.write(file.name, file.bytes);
    Recorder recorder(doings.source, folder.path());
    for (const std::string& command : doings.commands) recorder.act(command);
    for (int n = 1; with_checkpoints && n <= 2; ++n) {
        for (const std::string& command : doings.rest) recorder.act(command);
        (void)recorder.scene->update();
        Status saved = Ok{};
        recorder.records.push_back(
            checked(save_checkpoint(*recorder.scene, folder / "s.pls", n, saved)));
        check(saved);
        for (const std::string& command : doings.after) recorder.act(command);
    }
    if (with_marks) recorder.mark();
    return recorder.files(folder / "s.pls");
}

/// Corrects the checksums of checkpoints, if the session has those of the good ones, then the
/// session's.
void repair_all(Files& files, const Files& good) {
    std::string& text = files.front().bytes;
    for (std::size_t n = 1; n < good.size(); ++n) {
        repair_state(files[n].bytes);
        const std::string before = checksum_of_state(good[n].bytes);
        if (const std::size_t at = text.find(before); at != std::string::npos)
            text.replace(at, before.size(), checksum_of_state(files[n].bytes));
    }
    repair_session(text);
}

Seed seed_of(const std::string& name, const Doings& doings, bool marks, bool checkpoints) {
    Seed seed{.name = name,
              .files = session_files(doings, marks, checkpoints),
              .commands = {"replay s.pls --json --threads 1", "replay s.pls --threads 1"}};
    seed.repair = [good = seed.files](Files& files) { repair_all(files, good); };
    if (checkpoints) seed.commands.assign(1, "replay s.pls --from-checkpoint --threads 1");
    for (File file : doings.files) {
        file.fixed = true;
        seed.files.push_back(std::move(file));
    }
    return seed;
}

const Words kSessionWords = {"\"do\":\"push\"",
                             "\"do\":\"grab\"",
                             "\"do\":\"drag\"",
                             "\"do\":\"tissue\"",
                             "\"do\":\"open\"",
                             "\"do\":\"mark\"",
                             "\"do\":\"sweep\"",
                             "\"do\":\"relax\"",
                             "\"do\":\"break\"",
                             "\"do\":\"lost\"",
                             "\"do\":\"redo\"",
                             "\"do\":\"catheter\"",
                             "\"insert_mm_s\":",
                             "\"bend_first_deg\":",
                             "\"do\":\"reset\"",
                             "\"do\":\"checkpoint\"",
                             "\"count\":",
                             "\"radius\":",
                             "\"stroke\":",
                             "\"slide\":true",
                             "\"client\":",
                             "\"on\":true",
                             "\"model\":\"springs\"",
                             "\"nodes\":64",
                             "\"phantom\":\"airway\"",
                             "\"size\":[16,16,16]",
                             "\"file\":\"c.nrrd\"",
                             "\"refused\":true",
                             "null",
                             "true",
                             "[]",
                             "{}",
                             "\\u0000",
                             "\\ud800",
                             "\"\xff\"",
                             "[1,2,3]",
                             "1e400",
                             "{\"client\":1,\"do\":\"undo\"}\n",
                             "{\"do\":\"sweep\",\"count\":3}\n"};

}  // namespace

Format session(const Sources&) {
    const std::vector<std::string> push{kPush, kRelease};
    const Doings chainmail{kCube, {}, kCommands, {kRest}, push};
    const Doings springs{kCube, {}, kSpringCommands, {kRest}, push};
    const Doings catheter{{.file = "s.toml"},
                          vessel_files(),
                          kCatheterCommands,
                          {kStop, kManySweeps},
                          kCatheterCommands};
    return {.name = "session",
            .words = kSessionWords,
            .seeds = {seed_of("marks", chainmail, true, false),
                      seed_of("commands", chainmail, false, false),
                      seed_of("springs", springs, false, true),
                      seed_of("checkpoints", chainmail, false, true),
                      seed_of("catheter", catheter, true, false),
                      seed_of("catheter_checkpoints", catheter, false, true)},
            .may_be_long = true};
}

}  // namespace pliant::mutate
