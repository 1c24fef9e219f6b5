// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A session's file: a log with one line per record.
//
//   3f0c… {"pliant_session":1,"program":…,"source":{…},"scan":"…"}
//   91ab… {"client":1,"do":"push",…}
//   07d2… {"do":"sweep","count":3}
//   81c4… {"do":"sweep","count":0,"parts":5120}
//   c4e9… {"do":"mark","volume":"…","tissue":"…"}
//   5d02… {"do":"checkpoint","number":1,"file":"…","tissue":"…",…}
//   55d8… {"do":"open","source":{…},"scan":"…"}
//   b81c… {"do":"state","file":"…","checksum":"…"}
//   a2f7… {"client":1,"do":"break"}
//   66b0… {"do":"lost","steps":12}
//   2e19… {"do":"wait","ms":117}
//
// The number before each line is a checksum of the line and of the previous checksum. It detects
// unfinished lines and modified ones. Marks record the state of the scene; a replay compares it.
// Checkpoints record that the tissue's state was saved beside the session (checkpoint.h), and
// contain the rest of the scene's state. Continuing from a checkpoint loses the undo steps before
// it; the file records that (forget), because undo then ends there. When another scan is opened, a
// new scene begins, independent of the lines before. A state of the tissue that was loaded is in a
// file of its own; its checksum detects another one.
//
// A relative name of a scan or state refers to the folder of the session's file.

#pragma once

#include <pliant/result.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "base/descriptor.h"
#include "protocol/commands.h"
#include "session/scene_memo.h"
#include "session/source.h"

namespace pliant::serve {

/// Refused commands are recorded too, because they end the open step.
struct SessionCommand {
    std::uint32_t client = 0;
    Action action;
    bool refused = false;
};
struct SessionSweeps {
    int count = 0;                        ///< whole sweeps
    std::optional<std::int64_t> parts{};  ///< of an unfinished sweep after them, see SweepLimit
};
struct SessionMark {
    std::uint64_t volume = 0, tissue = 0;
};
struct SessionCheckpoint {
    int number = 1;          ///< 1, 2, …
    std::uint64_t file = 0;  ///< checksum at the end of the state's file
    SessionMark mark;
    SceneMemo memo;
};
struct SessionForget {
    std::int64_t steps = 0;  ///< steps of undo made so far
};
/// A command ran out of memory; its only effect was Scene::interrupt().
struct SessionBreak {
    std::uint32_t client = 0;
};
/// All steps of undo were dropped.
struct SessionLost {
    std::int64_t steps = 0;  ///< steps made so far
};
/// Also written as the file's header line.
struct SessionHeader {
    SceneSource source;
    std::uint64_t scan_hash = 0;
};
/// Another scan was opened.
struct SessionOpen {
    SessionHeader scan;
};
/// A saved state of the tissue was loaded, and the history ended.
struct SessionState {
    std::string file;            ///< absolute in memory; in the session perhaps relative to it
    std::uint64_t checksum = 0;  ///< at the end of the file
};
/// Wall-clock time since the previous record of this kind, or the begin. A replay doesn't need it.
struct SessionWait {
    int ms = 0;
};
inline constexpr int kMaxWait_ms = 1'000'000'000;
inline constexpr std::chrono::milliseconds kSessionTick{100};  ///< shortest wait
using SessionRecord =
    std::variant<SessionCommand, SessionSweeps, SessionMark, SessionCheckpoint, SessionForget,
                 SessionBreak, SessionLost, SessionOpen, SessionState, SessionWait>;

std::string text_of(const SessionHeader& header);
std::string text_of(const SessionRecord& record);
Result<SessionHeader> parse_session_header(std::string_view text);
Result<SessionRecord> parse_session_record(std::string_view text);

/// Contents of a file, up to its last complete line.
struct SessionFile {
    SessionHeader header;
    std::vector<SessionRecord> records;
    std::uint64_t chain = 0;          ///< checksum of the last line
    std::uint64_t good_bytes = 0;     ///< length of the complete lines
    std::uint64_t cut_off_bytes = 0;  ///< length of the unfinished line after them

    /// Gives all its scenes a tissue of one's own.
    void use_tissue(const std::shared_ptr<const MakeTissue>& own_tissue);

    // The newest scene.
    SessionHeader scene;
    std::size_t scene_records = 0;  ///< its first record, and its offset in the file
    std::uint64_t scene_begin = 0;
};

/// The records of one scene, in a file that is still growing.
struct SessionPart {
    SessionHeader scene;
    std::shared_ptr<const Descriptor> file;
    std::uint64_t begin = 0, end = 0;
};
/// Writes the part as a separate session, with a mark at its end.
Status write_session(const std::filesystem::path& path, const SessionPart& part,
                     const SessionMark& mark);

/// @returns NotFound; Unreadable that names a damaged line before the end of the file, so that no
///          record is left out silently
Result<SessionFile> read_session(const std::filesystem::path& path) noexcept;

/// Whether there is a session's file with content.
/// @returns Unreadable if the system can't tell
Result<bool> session_has_begun(const std::filesystem::path& path);

/// The open session file. Records are in the file after a successful flush(), and on the disk at
/// most a second later. If the disk is full they stay in memory, and the next flush() retries. The
/// file is locked against other programs.
class SessionLog {
  public:
    /// Creates a file, or begins in an empty one, which a start that failed or was killed leaves.
    /// @returns Unwritable if it has content or can't be created
    static Result<std::unique_ptr<SessionLog>> create(const std::filesystem::path& path,
                                                      const SessionHeader& header);
    /// Continues a file, and truncates it after its complete lines.
    static Result<std::unique_ptr<SessionLog>> go_on(const std::filesystem::path& path,
                                                     const SessionFile& read);
    /// Creates an anonymous, size-limited file that ends with the program.
    static Result<std::unique_ptr<SessionLog>> create_nameless(const SessionHeader& header);
    ~SessionLog();
    SessionLog(const SessionLog&) = delete;
    SessionLog& operator=(const SessionLog&) = delete;

    /// Adds a record. If it throws std::bad_alloc, nothing was added.
    void add(const SessionRecord& record);
    /// @returns Unwritable if records are still in memory, or if a nameless file is full, which
    ///          ends its recording
    Status flush();
    /// @returns Unwritable if the file was moved or deleted
    Status check_path() const;
    /// Whether the reserved memory for records is used up. Then no command may be carried out.
    bool is_full() const;
    const std::string& path() const { return m_path; }
    /// Records of the current scene so far.
    Result<SessionPart> part();
    bool is_nameless() const { return m_most_bytes > 0; }

  private:
    SessionLog(const std::filesystem::path& path, Descriptor file, const SessionFile& read);
    Status begin(const SessionHeader& header);
    void add_line(const std::string& text);
    void keep_syncing(const std::stop_token& stop);
    void sync();
    int write_buffer();

    std::string m_path;
    Descriptor m_file;
    std::uint64_t m_chain;
    std::uint64_t m_written;         ///< length of the file
    std::uint64_t m_most_bytes = 0;  ///< limit of the length; 0: none
    SessionHeader m_scene;
    std::uint64_t m_scene_begin;
    std::string m_buffer;
    bool m_ended = false;  ///< a nameless file is full
    std::mutex m_mutex;    ///< guards m_unsynced
    std::condition_variable_any m_wake;
    bool m_unsynced = false;
    std::atomic<int> m_sync_error = 0;  ///< errno of the last sync; 0: it succeeded
    std::jthread m_syncer;              ///< syncs in the background, because the disk may be slow
};

}  // namespace pliant::serve
