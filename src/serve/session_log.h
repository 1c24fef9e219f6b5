// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A session's file: what was done, one line each, as it happens.
//
//   3f0c… {"pliant_session":1,"program":…,"source":{…},"scan":"…"}
//   91ab… {"client":1,"do":"push",…}
//   07d2… {"do":"sweep","count":3}
//   c4e9… {"do":"mark","volume":"…","tissue":"…"}
//   5d02… {"do":"checkpoint","number":1,"file":"…","tissue":"…",…}
//   55d8… {"do":"open","source":{…},"scan":"…"}
//   a2f7… {"client":1,"do":"break"}
//   66b0… {"do":"lost","steps":12}
//
// The number before each line is a checksum of the line and of the checksum before it. So a line
// that the machine had no time to finish is found, and so is one that somebody changed. Marks say
// what the scene was at that point; whoever replays the session compares. Checkpoints say that the
// tissue's state at that point was saved beside the session (checkpoint.h), and hold the rest of
// the scene themselves. Whoever goes on from one has lost the steps before it, and the file says so
// (forget), because from then on undo ends there. Where another scan was opened a new scene begins:
// what was before it counts for nothing that comes after.
//
// A scan's name that isn't absolute is looked for beside the session's file.

#pragma once

#include <pliant/result.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "serve/commands.h"
#include "serve/scene_memo.h"
#include "serve/source.h"

namespace pliant::serve {

/// Refused commands are recorded too: they end what was going on before.
struct SessionCommand {
    std::uint32_t client = 0;
    Action action;
    bool refused = false;
};
struct SessionSweeps {
    int count = 0;
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
    std::int64_t steps = 0;  ///< of undo that were made so far
};
/// A command ran out of memory: the step that went on has ended, and nothing else was done. One
/// that hasn't even done that isn't recorded.
struct SessionBreak {
    std::uint32_t client = 0;
};
/// No step can be undone any more.
struct SessionLost {
    std::int64_t steps = 0;  ///< that were made so far
};
/// Also the first line of a file, in other words.
struct SessionHeader {
    SceneSource source;
    std::uint64_t scan_hash = 0;
};
/// Another scan was opened.
struct SessionOpen {
    SessionHeader scan;
};
using SessionRecord = std::variant<SessionCommand, SessionSweeps, SessionMark, SessionCheckpoint,
                                   SessionForget, SessionBreak, SessionLost, SessionOpen>;

std::string text_of(const SessionHeader& header);
std::string text_of(const SessionRecord& record);
Result<SessionHeader> parse_session_header(std::string_view text);
Result<SessionRecord> parse_session_record(std::string_view text);

/// What a file holds, up to the last line that is whole.
struct SessionFile {
    SessionHeader header;
    std::vector<SessionRecord> records;
    std::uint64_t chain = 0;          ///< checksum of the last line
    std::uint64_t good_bytes = 0;     ///< of the whole lines
    std::uint64_t cut_off_bytes = 0;  ///< after them: a line that was not finished

    // The newest scene.
    SessionHeader scene;
    std::size_t scene_records = 0;  ///< its first record, and where that begins in the file
    std::uint64_t scene_begin = 0;
};

/// What was done to one scene, as it stands in a file that goes on growing.
struct SessionPart {
    SessionHeader scene;
    std::shared_ptr<const int> file;  ///< a descriptor of its own
    std::uint64_t begin = 0, end = 0;
};
/// Writes it as a session of its own, with a mark at its end.
Status write_session(const std::filesystem::path& path, const SessionPart& part,
                     const SessionMark& mark);

/// @returns NotFound; Unreadable that names the line where the file is damaged before its end, so
///          that nothing is left out silently
Result<SessionFile> read_session(const std::filesystem::path& path) noexcept;

/// A file that grows. Records are in the file after a flush() that succeeds, and on the disk at
/// most a second later. Where the disk is full they are kept in memory, and the next flush() tries
/// again. The file is locked: other programs must not write to it.
class SessionLog {
  public:
    /// A new file. @returns Unwritable where there is one already, or none can be made
    static Result<std::unique_ptr<SessionLog>> create(const std::filesystem::path& path,
                                                      const SessionHeader& header);
    /// Goes on with a file; what it holds after the whole lines is cut off.
    static Result<std::unique_ptr<SessionLog>> go_on(const std::filesystem::path& path,
                                                     const SessionFile& file);
    /// A file without a name, that ends with the program, and must not grow without end.
    static Result<std::unique_ptr<SessionLog>> create_nameless(const SessionHeader& header);
    ~SessionLog();
    SessionLog(const SessionLog&) = delete;
    SessionLog& operator=(const SessionLog&) = delete;

    /// Where it throws std::bad_alloc, nothing was added.
    void add(const SessionRecord& record);
    /// @returns Unwritable where records had to be kept, or where a nameless file is full, which
    ///          records nothing more
    Status flush();
    /// @returns Unwritable where the file was moved or deleted
    Status check_place() const;
    /// Whether more records are kept than memory is set aside for. Nothing else may be done then.
    bool is_full() const;
    const std::string& path() const { return m_path; }
    /// What was done to the scene so far.
    Result<SessionPart> part();
    bool is_nameless() const { return m_most_bytes > 0; }

  private:
    SessionLog(const std::filesystem::path& path, int descriptor, const SessionFile& file);
    Status begin(const SessionHeader& header);
    void add_line(const std::string& text);
    void keep_syncing(const std::stop_token& stop);
    void sync();
    int write_buffer();

    std::string m_path;
    int m_descriptor;
    std::uint64_t m_chain;
    std::uint64_t m_written;         ///< bytes of the file
    std::uint64_t m_most_bytes = 0;  ///< that it may have; 0: no limit
    SessionHeader m_scene;
    std::uint64_t m_scene_begin;
    std::string m_buffer;
    bool m_ended = false;  ///< a nameless file that is full
    std::mutex m_mutex;    ///< of m_unsynced
    std::condition_variable_any m_wake;
    bool m_unsynced = false;
    std::atomic<int> m_sync_error = 0;  ///< errno of the last sync; 0: it succeeded
    std::jthread m_syncer;              ///< the disk may take long, which is not the scene's time
};

}  // namespace pliant::serve
