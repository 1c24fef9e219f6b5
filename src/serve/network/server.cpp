// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Public interface of the server: a scene, its owner's thread, and the network's thread.

#include <pliant/serve.h>
#include <unistd.h>

#include <condition_variable>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>

#include "base/errors.h"
#include "hub/hub.h"
#include "network/network.h"
#include "session/checkpoint.h"

namespace pliant {

struct Server::Impl {
    std::unique_ptr<serve::Hub> hub;
    std::unique_ptr<serve::Network> network;
    serve::Tokens tokens;
    std::vector<std::string> notes;
    std::mutex mutex;
    std::condition_variable stopped;
    bool is_stopped = false;
    std::jthread network_thread;
    std::jthread owner_thread;

    ~Impl() {
        // The owner closes all connections, and the network completes the handshakes.
        if (owner_thread.joinable()) {
            owner_thread.request_stop();
            owner_thread.join();
        }
        if (network) network->stop();
        if (network_thread.joinable()) network_thread.join();
    }
};

namespace {

struct OpenedScene {
    std::unique_ptr<serve::Scene> scene;
    std::unique_ptr<serve::SessionLog> log;
    std::vector<std::string> notes;
    int checkpoints = 0;  ///< number in the session
    std::shared_ptr<const MakeTissue> own_tissue{};
    std::optional<serve::SessionFile> watched{};
};

std::string name_of(const serve::SceneSource& source) {
    return source.file.empty() ? "the " + source.phantom + " phantom" : source.file;
}

/// Checks that a session began with the given state.
Status check_first_state(const serve::SessionFile& file, const std::string& path,
                         const std::string& state) {
    const auto* first =
        file.records.empty() ? nullptr : std::get_if<serve::SessionState>(&file.records.front());
    if (first && first->file == state) return Ok{};
    return about("load_state", ErrorCode::InvalidArgument,
                 "expected a new session, or one that began with " + state + ", found " + path);
}

/// @param state  file of the state that the session must have begun with; empty: any
Result<OpenedScene> go_on(const std::filesystem::path& path, serve::SceneSource source,
                          const std::string& state, bool any_source, const TaskArena& arena) {
    const auto named = [&](const Error& error) {
        return Error{error.code, path.string() + ": " + error.message};
    };
    auto file = serve::read_session(path);
    if (!file.ok()) return file.error();
    file->use_tissue(source.own_tissue);
    if (source.model == serve::kChosenModel) source.model = file->header.source.model;
    if (!any_source && !(file->header.source == source))
        return named({ErrorCode::InvalidArgument, "expected a session of " + name_of(source) +
                                                      ", found one of " +
                                                      name_of(file->header.source)});
    if (!state.empty())
        if (const Status s = check_first_state(*file, path.string(), state); !s.ok())
            return s.error();
    OpenedScene opened;
    // Locks the file before the long work begins.
    auto log = serve::SessionLog::go_on(path, *file);
    if (!log.ok()) return log.error();
    auto reopened = serve::reopen(*file, path, arena);
    if (!reopened.ok()) return named(reopened.error());
    if (reopened->number) (*log)->add(serve::SessionForget{reopened->forgot});
    for (const std::string& note : reopened->notes)
        opened.notes.push_back(path.string() + ": " + note);
    opened.notes.push_back(
        path.string() + ": went on after " + std::to_string(file->records.size()) + " records" +
        (reopened->number
             ? ", from checkpoint " + std::to_string(reopened->number) + "; undo goes back to there"
             : ""));
    for (const auto& record : file->records)
        if (const auto* point = std::get_if<serve::SessionCheckpoint>(&record))
            opened.checkpoints = point->number;
    if (file->cut_off_bytes)
        opened.notes.push_back(path.string() + ": the last line was not finished; " +
                               std::to_string(file->cut_off_bytes) + " bytes were cut off");
    opened.scene = std::move(reopened->scene);
    opened.own_tissue = source.own_tissue;
    opened.log = std::move(*log);
    return opened;
}

/// Opens the last scene of a session that is watched, at rest.
Result<OpenedScene> open_watched(const ServerSettings& settings, const TaskArena& arena) {
    const std::string name = settings.replay.string();
    if (!settings.file.empty() || !settings.session.empty())
        return about("replay", ErrorCode::InvalidArgument,
                     "expected neither a scan nor a session beside it, found " +
                         (settings.file.empty() ? settings.session.string() : settings.file));
    if (!settings.load_state.empty())
        return about(
            "load_state", ErrorCode::InvalidArgument,
            "expected none beside a session that is watched, found " + settings.load_state);
    auto file = serve::read_session(settings.replay);
    if (!file.ok()) return file.error();
    if (settings.own_tissue)
        file->use_tissue(std::make_shared<const MakeTissue>(settings.own_tissue));
    auto scene = serve::open_recorded(file->scene, arena);
    if (!scene.ok()) return Error{scene.error().code, name + ": " + scene.error().message};
    OpenedScene opened{.scene = std::move(*scene),
                       .log = {},
                       .notes = {},
                       .checkpoints = 0,
                       .own_tissue = {},
                       .watched = {}};
    if (file->scene_records > 0)
        opened.notes.push_back(name + ": has several scans; the last one is watched");
    if (file->cut_off_bytes > 0)
        opened.notes.push_back(name + ": the last line was not finished and is left out");
    opened.watched = std::move(*file);
    return opened;
}

/// Opens a new scene, with a saved state unless its file's name is empty. If the model is chosen,
/// the state chooses it: one of ChainMail or the scene's own tissue, or one of the elastic scan.
Result<std::unique_ptr<serve::Scene>> open_with_state(serve::SceneSource source,
                                                      const std::string& state,
                                                      const TaskArena& arena) {
    if (state.empty()) return serve::Scene::open(source, arena);
    const bool is_chosen = source.model == serve::kChosenModel;
    if (is_chosen) source.model.clear();
    auto scene = serve::Scene::open(source, arena);
    if (!scene.ok()) return scene.error();
    const Status loaded = (*scene)->load_state(state);
    if (loaded.ok()) return scene;
    if (is_chosen) {
        source.model = "elastic";
        auto elastic = serve::Scene::open(source, arena);
        if (elastic.ok() && (*elastic)->load_state(state).ok()) return elastic;
    }
    return about("load_state", loaded.error().code, loaded.error().message);
}

Result<OpenedScene> open_scene(const ServerSettings& settings, const TaskArena& arena) {
    if (!settings.replay.empty()) return open_watched(settings, arena);
    if (settings.bodies && settings.labels.empty())
        return expected_error("bodies", "a label map in labels, of which they are made", "none");
    if (!settings.label_names.empty() && settings.labels.empty())
        return expected_error("label_names", "a label map in labels, whose names these are",
                              "none");
    std::error_code error;
    serve::SceneSource source{.series = settings.series,
                              .phantom_size = settings.phantom_size,
                              .frame = settings.frame,
                              .straighten = settings.straighten,
                              .spacing_mm = settings.spacing_mm,
                              .units = settings.units};
    if (settings.own_tissue)
        source.own_tissue = std::make_shared<const MakeTissue>(settings.own_tissue);
    const auto absolute = [&](const std::string& file) {
        if (file.empty()) return file;
        return std::filesystem::absolute(file, error).lexically_normal().string();
    };
    source.file = absolute(settings.file);
    source.config = absolute(settings.config);
    // Without settings it is shown only.
    source.bodies = settings.bodies;
    if (!settings.config.empty() || source.bodies) source.labels = absolute(settings.labels);
    if (source.bodies) source.label_names = absolute(settings.label_names);
    source.directions = absolute(settings.directions);
    source.model = settings.model;
    source.network = absolute(settings.network);
    const auto has_begun =
        settings.session.empty() ? Result<bool>(false) : serve::session_has_begun(settings.session);
    if (!has_begun.ok()) return has_begun.error();
    if (*has_begun)
        return go_on(settings.session, source, absolute(settings.load_state), settings.file.empty(),
                     arena);
    serve::SessionState state{.file = absolute(settings.load_state)};
    auto scene = open_with_state(source, state.file, arena);
    if (!scene.ok()) return scene.error();
    if (!state.file.empty()) {
        const auto checksum = serve::checksum_of(state.file);
        if (!checksum.ok())
            return about("load_state", checksum.error().code, checksum.error().message);
        state.checksum = *checksum;
    }
    OpenedScene opened{.scene = std::move(*scene),
                       .log = {},
                       .notes = {},
                       .checkpoints = 0,
                       .own_tissue = source.own_tissue,
                       .watched = {}};
    source.model = opened.scene->first_model().model;
    if (const std::string& reason = opened.scene->first_model().reason; !reason.empty())
        opened.notes.push_back(reason);
    const serve::SessionHeader header{source, opened.scene->scan_hash()};
    auto log = settings.session.empty() ? serve::SessionLog::create_nameless(header)
                                        : serve::SessionLog::create(settings.session, header);
    if (log.ok()) {
        opened.log = std::move(*log);
        if (!state.file.empty()) opened.log->add(state);
    } else if (settings.session.empty()) {
        opened.notes.push_back(log.error().message + "; no session can be saved");
    } else {
        return log.error();
    }
    return opened;
}

/// Folder and limits of uploaded scans.
serve::UploadSettings upload_settings(const ServerSettings& settings) {
    serve::UploadSettings uploads{.folder = {}, .max_bytes = settings.max_upload_bytes};
    if (settings.session.empty()) return uploads;
    std::error_code error;
    const auto session = std::filesystem::absolute(settings.session, error).lexically_normal();
    uploads.folder = session.string() + ".scans";
    uploads.keeps = true;
    return uploads;
}

}  // namespace

Result<Server> Server::start(const ServerSettings& settings, const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<Server> {
        try {
            return begin(settings, arena);
        } catch (const std::system_error& error) {
            return Error{
                ErrorCode::LimitExceeded,
                std::string("serve: a thread can't be started: ") + error.code().message()};
        }
    });
}

SettingRows<ServerSettings> server_rows() noexcept {
    using S = ServerSettings;
    static constexpr Setting<S> kRows[] = {
        setting<&S::file>({.name = "file", .text = "scan; empty: the airway phantom"}),
        setting<&S::series>(
            {.name = "series",
             .text =
                 "DICOM series of a folder with several: number, part of the description, or UID"}),
        setting<&S::labels>({.name = "labels", .text = "label map over the scan; empty: none"}),
        setting<&S::label_names>(
            {.name = "label_names", .text = "table of the labels' names; empty: the map's own"}),
        setting<&S::config>(
            {.name = "config", .text = "settings of ChainMail and the elastic scan, TOML"}),
        setting<&S::directions>(
            {.name = "directions", .text = "field of directions for its label materials"}),
        setting<&S::model>({.name = "model",
                            .text = "tissue at first: chainmail, elastic, springs, or auto: the "
                                    "elastic scan if it makes 25 pictures a second; empty: the "
                                    "scene's own, or chainmail"}),
        setting<&S::network>(
            {.name = "network", .text = "network of springs that moves the scan; empty: none"}),
        setting<&S::port>({.name = "port", .range = {0, 65535}, .text = "0: a free port"}),
        setting<&S::host>({.name = "host",
                           .text = "address of this machine to listen on; 0.0.0.0: all, with a "
                                   "certificate"}),
        setting<&S::certificate>(
            {.name = "certificate", .text = "PEM file, with the certificates that sign it"}),
        setting<&S::key>({.name = "key", .text = "PEM file with the certificate's private key"}),
        setting<&S::url>(
            {.name = "url", .text = "of the page, if a proxy stands in front of the server"}),
        setting<&S::rate_hz>({.name = "rate_hz",
                              .unit = "Hz",
                              .range = {1, 1000},
                              .text = "maximum steps of the scene per second"}),
        setting<&S::checkpoint_s>({.name = "checkpoint_s",
                                   .unit = "s",
                                   .range = {.low = 0},
                                   .text = "work between two checkpoints"}),
        setting<&S::max_spring_nodes>({.name = "max_spring_nodes",
                                       .range = {3, 64},
                                       .text = "limit of control nodes along an axis in the "
                                               "springs model"}),
        setting<&S::network_hz>({.name = "network_hz",
                                 .unit = "Hz",
                                 .range = {0, 1000},
                                 .text = "updates per second that an automatic depth of springs "
                                         "leaves to the slowest client; 0: any"}),
    };
    return kRows;
}

namespace {

Result<serve::Address> address_of(const ServerSettings& settings) {
    serve::Address address{.host = settings.host,
                           .port = settings.port,
                           .tls = {},
                           .url = settings.url,
                           .embed_in = settings.embed_in};
    if (settings.certificate.empty() != settings.key.empty())
        return about(settings.key.empty() ? "key" : "certificate", ErrorCode::InvalidArgument,
                     "expected a file, since certificate and key belong together, found none");
    if (settings.certificate.empty()) return address;
    auto tls = serve::Tls::create(settings.certificate, settings.key);
    if (!tls.ok()) return tls.error();
    address.tls = std::move(*tls);
    return address;
}

}  // namespace

Result<Server> Server::begin(const ServerSettings& settings, const TaskArena& arena) {
    if (const Status status = check(settings, server_rows()); !status.ok()) return status.error();
    if (settings.config.empty() && !settings.directions.empty())
        return about("directions", ErrorCode::InvalidArgument,
                     "expected settings with [[label]] tables as well, found none");
    auto address = address_of(settings);
    if (!address.ok()) return address.error();
    auto opened = open_scene(settings, arena);
    if (!opened.ok()) return opened.error();
    auto tokens = settings.session.empty() ? Result<serve::Tokens>(serve::random_tokens())
                                           : serve::tokens_of_session(settings.session);
    if (!tokens.ok()) return tokens.error();
    std::shared_ptr<const serve::LabelMap> labels;
    if (!settings.labels.empty()) {
        auto read = serve::read_label_map(settings.labels, opened->scene->info().grid, arena, {},
                                          settings.label_names);
        if (!read.ok())
            return read.error().field.empty()
                       ? about("labels", read.error().code, read.error().message)
                       : read.error();
        labels = std::move(*read);
    }
    auto impl = std::make_unique<Impl>();
    impl->notes = std::move(opened->notes);
    const std::string remark =
        remark_on(opened->scene->info().values, "the page's threshold, window and material");
    if (!remark.empty()) impl->notes.push_back(remark);
    impl->tokens = std::move(*tokens);
    const serve::UploadSettings uploads = upload_settings(settings);
    if (uploads.keeps) serve::sweep_uploads(uploads.folder);
    impl->hub = std::make_unique<serve::Hub>(std::move(opened->scene), std::move(opened->log),
                                             settings.rate_hz, settings.max_upload_bytes);
    impl->hub->offer_devices(serve::HapticDevices(settings.haptic_devices));
    impl->hub->bound_springs(settings.max_spring_nodes);
    impl->hub->want_updates(settings.network_hz);
    impl->hub->post({0, serve::Event::Labelling{std::move(labels), [](bool) {}}});
    impl->hub->keep_checkpoints(settings.checkpoint_s, opened->checkpoints);
    const bool is_watched = opened->watched.has_value();
    if (is_watched) impl->hub->watch(std::move(*opened->watched), arena);
    auto network =
        serve::Network::listen(std::move(*address), impl->tokens, *impl->hub,
                               {uploads, arena, opened->own_tissue, settings.model, !is_watched});
    if (!network.ok()) return network.error();
    impl->network = std::move(*network);
    impl->network_thread = std::jthread([network = impl->network.get()] { network->run(); });
    impl->owner_thread =
        std::jthread([hub = impl->hub.get(), network = impl->network.get()](
                         const std::stop_token& stop) { hub->run(stop, *network); });
    return Server(std::move(impl));
}

Server::Server(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
Server::~Server() = default;
Server::Server(Server&&) noexcept = default;
Server& Server::operator=(Server&&) noexcept = default;

int Server::port() const {
    return m_impl->network->port();
}
std::string Server::link() const {
    return m_impl->network->url() + "#token=" + m_impl->tokens.control;
}
std::string Server::view_link() const {
    return m_impl->network->url() + "#token=" + m_impl->tokens.view;
}
const std::vector<std::string>& Server::notes() const {
    return m_impl->notes;
}

std::int64_t Server::ticks() const {
    return m_impl->hub->ticks();
}

void Server::wait() {
    std::unique_lock lock(m_impl->mutex);
    m_impl->stopped.wait(lock, [&] { return m_impl->is_stopped; });
}

void Server::stop() {
    {
        const std::lock_guard lock(m_impl->mutex);
        m_impl->is_stopped = true;
    }
    m_impl->stopped.notify_all();
}

}  // namespace pliant
