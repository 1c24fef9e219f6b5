// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Saving and opening files. The owner only copies the changed state, or swaps a pointer. Other
// threads read and write.

#include <new>

#include "hub/hub.h"
#include "protocol/limits.h"
#include "session/checkpoint.h"

namespace pliant::serve {

void Hub::save(SaveKind kind, std::function<void(Result<FileWriter>)> ready) {
    post({0, Saving{kind, std::move(ready)}});
}

void Hub::open(NewScene scene, std::function<void(std::unique_ptr<Scene> old)> done) {
    post({0, Opening{std::move(scene), std::move(done)}});
}

void Hub::load_state(std::filesystem::path file, std::string recorded,
                     std::function<void(Status loaded)> done) {
    post({0, Restoring{std::move(file), std::move(recorded), std::move(done)}});
}

void Hub::show_labels(std::shared_ptr<const LabelMap> map, std::function<void(bool)> done) {
    post({0, Labelling{std::move(map), std::move(done)}});
}

Grid Hub::grid() const {
    const std::lock_guard lock(m_mutex);
    return m_grid;
}

/// Another scan may have been opened while the map was read.
void Hub::take(ConnectionId, Labelling& labelling) {
    const bool fits = !labelling.map || labelling.map->grid == m_scene->info().grid;
    if (fits) m_labels.show(labelling.map);
    m_worked = true;
    labelling.done(fits);
}

void Hub::take(ConnectionId, Saving& saving) {
    const auto writer = [&]() -> Result<FileWriter> {
        try {
            if (saving.kind == SaveKind::State) return save_state_later(*m_scene);
            if (saving.kind != SaveKind::Session) return save_later(saving.kind, *m_scene);
            if (!m_log)
                return Error{ErrorCode::Unwritable,
                             "session.pls: expected a session that is recorded, found none"};
            auto part = m_log->part();
            if (!part.ok()) return part.error();
            return save_session_later(std::move(*part), *m_scene);
        } catch (const std::bad_alloc&) {
            return Error{ErrorCode::LimitExceeded, "save: not enough memory for a copy"};
        }
    };
    saving.ready(writer());
}

/// Begins once memory is available and all earlier commands are recorded.
void Hub::take(ConnectionId, Restoring& restoring) {
    if (!log_is_ready()) throw std::bad_alloc();
    const Status loaded = m_scene->load_state(restoring.file);
    if (loaded.ok()) {
        note(SessionState{std::move(restoring.recorded), checksum_of(restoring.file).value_or(0)});
        change_tissue();
        if (m_scene->take_lost()) note(SessionLost{m_scene->steps()});
        m_moved = true;
    }
    m_worked = true;
    restoring.done(loaded);
}

/// Begins once memory is available and all earlier commands are recorded.
void Hub::take(ConnectionId, Opening& opening) {
    if (!log_is_ready()) throw std::bad_alloc();
    DirtyBlocks deformed(opening.scene.scene->info().grid.size);
    opening.scene.scene->set_volume_id(m_scene->info().id + 1);
    for (Feed* feed : m_feeds) feed->leave_scene();
    std::swap(m_scene, opening.scene.scene);
    {
        const std::lock_guard lock(m_mutex);
        m_grid = m_scene->info().grid;
    }
    m_deformed = std::move(deformed);
    m_changes.forget();
    note(SessionOpen{std::move(opening.scene.recorded)});
    ++m_step;
    const SharedState none;
    m_timing = none;
    m_unsaved_ms = 0;
    m_is_unsaved = false;
    m_checksums.reset();
    m_worked = true;
    for (Feed* feed : m_feeds) feed->enter_scene();
    m_tools.clear();
    m_tools_version = 0;  // forces a new frame for the new scan
    for (Client& client : m_clients) {
        // A client that can't be informed must reconnect.
        if (!guarded("owner", [&] { begin_anew(client); }) && client.connection)
            guarded("owner", [&] { drop(client, kCloseStalled, "out of memory"); });
    }
    m_is_behind = !guarded("owner", [&] {
        const auto update = m_scene->update();
        if (!update) throw std::bad_alloc();
        for (const Box3i& box : update->boxes) m_deformed.mark(box);
    });
    guarded("owner", [&] { opening.done(std::move(opening.scene.scene)); });
}

/// Resets a client's state for a new scan.
void Hub::begin_anew(Client& client) {
    client.delivery = Delivery(m_scene->info().grid.size);
    client.line = {};
    client.traffic = {};
    client.delivery.mark_all();
    client.coarse_is_due = true;
    client.tool = {};
    client.eye = {};
    client.tools_version = 0;
    if (!client.connection) return;
    say(client, volume_text(m_scene->info()));
    for (const Waiting& waiting : std::exchange(client.commands, {})) {
        const std::string name(name_of(waiting.message.action));
        const Outcome refusal{.error_code = "other_scan",
                              .message = name + ": another scan was opened meanwhile"};
        for (const std::uint32_t id : waiting.merged)
            say(client, outcome_text(id, name, 0, refusal));
        say(client, outcome_text(waiting.message.id, name, 0, refusal));
    }
    client.scene_step = m_step;
}

}  // namespace pliant::serve
