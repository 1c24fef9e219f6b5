// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "mutate/upload_server.h"

#include <algorithm>
#include <cctype>
#include <csignal>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <thread>

#include "mutate/formats.h"
#include "support/connection.h"

namespace pliant::mutate {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double kMaxAnswerS = 10;
constexpr std::chrono::seconds kStartTime{60}, kEndTime{20}, kRemovalTime{5};

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

template <class Condition>
bool comes_about(std::chrono::seconds most, const Condition& condition) {
    for (const auto start = Clock::now(); !condition();) {
        if (Clock::now() - start > most) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
}

std::string encoded(const std::string& text) {
    std::string all;
    for (const char c : text) {
        char escaped[4];
        std::snprintf(escaped, sizeof escaped, "%%%02x", unsigned(static_cast<unsigned char>(c)));
        all += std::isalnum(static_cast<unsigned char>(c)) ? std::string(1, c) : escaped;
    }
    return all;
}

std::string proc(pid_t process, const char* file) {
    return "/proc/" + std::to_string(process) + "/" + file;
}

/// Largest resident memory since reset_peak() [MB]; 0 where the kernel doesn't say.
double peak_mb_of(pid_t process) {
    std::ifstream lines(proc(process, "status"));
    for (std::string line; std::getline(lines, line);)
        if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024;
    return 0;
}

void reset_peak(pid_t process) {
    std::ofstream(proc(process, "clear_refs")) << "5";
}

}  // namespace

UploadServer::UploadServer(Sources sources, bool judge_memory)
    : m_sources(std::move(sources)), m_judge_memory(judge_memory) {
    fs::create_directory(m_folder / ".tmp");
    m_folder.write("c.nrrd", cube(m_sources, "8"));
    start();
}

void UploadServer::start() {
    Limits limits{.cpu_s = 0, .wall_s = 0};
    if (!m_judge_memory) limits.memory = 0;
    const std::vector<std::string> words{"serve", "c.nrrd",    "--model",   "chainmail", "--port",
                                         "0",     "--no-open", "--threads", "1"};
    m_server = std::make_unique<Child>(m_sources.program, words, m_folder.path(), limits);
    m_said = 0;
    std::string link;
    const bool is_there = comes_about(kStartTime, [&] {
        const std::string said = m_server->out();
        const auto at = said.find("Open  "), end = said.find('\n', at == said.npos ? 0 : at);
        if (at != said.npos && end != said.npos) link = said.substr(at + 6, end - at - 6);
        return !link.empty() || m_server->has_ended();
    });
    if (!is_there || link.empty()) give_up("pliant serve: no link: " + m_server->err());
    m_port = std::stoi(link.substr(link.find(':', 6) + 1));
    m_token = test::token_of(link);
}

std::string UploadServer::target(const std::string& path) const {
    return path + "?token=" + m_token + "&upload=u" + std::to_string(m_uploads);
}

/// @param body  null: GET
Answer UploadServer::ask(const std::string& path, const std::string* body) {
    const auto start = Clock::now();
    test::Connection connection(m_port);
    const std::string response =
        body ? connection.post(path, *body) : connection.get(path, connection.host());
    return {.status = test::status_of(response),
            .body = test::body_of(response),
            .seconds = seconds_since(start)};
}

void UploadServer::judge(const Answer& answer, const std::vector<std::string>& expected,
                         std::vector<std::string>& faults) const {
    const double most = m_judge_memory ? kMaxAnswerS : 3 * kMaxAnswerS;
    for (std::string& fault : faults_of(answer, expected, most)) faults.push_back(std::move(fault));
}

Answer UploadServer::upload(const Files& files, bool first_series,
                            std::vector<std::string>& faults) {
    ++m_uploads;
    for (const File& file : files) {
        const std::string name = fs::path(file.name).filename().string();
        Answer answer = ask(target("/open/part") + "&name=" + encoded(name), &file.bytes);
        judge(answer, {"200", "400", "413"}, faults);
        if (answer.status != "200") return answer;
    }
    const std::string nothing;
    Answer answer = ask(target("/open/done") + "&name=scan", &nothing);
    judge(answer, {"200", "300", "400", "413"}, faults);
    return answer.status == "300" ? choose(answer, first_series, faults) : answer;
}

Answer UploadServer::choose(const Answer& choice, bool first_series,
                            std::vector<std::string>& faults) {
    const std::string nothing;
    const auto list = nlohmann::json::parse(choice.body, nullptr, false);
    std::string uid;
    if (list.is_object() && list.contains("series") && list["series"].size() > 1)
        uid = list["series"][0].value("uid", "");
    else
        faults.push_back("expected a list of series");
    if (!first_series || uid.empty()) {
        Answer dropped = ask(target("/open/drop"), &nothing);
        judge(dropped, {"200"}, faults);
        dropped.status = "300";  // nothing was opened
        return dropped;
    }
    Answer opened = ask(target("/open/done") + "&name=scan&series=" + encoded(uid), &nothing);
    judge(opened, {"200", "400", "413"}, faults);
    return opened;
}

void UploadServer::judge_leftovers(std::vector<std::string>& faults) const {
    if (comes_about(kRemovalTime, [&] { return fs::is_empty(m_folder / ".tmp"); })) return;
    for (const auto& entry : fs::directory_iterator(m_folder / ".tmp")) {
        faults.push_back("left behind: " + printable(entry.path().filename().string(), 60));
        std::error_code ignored;
        fs::remove_all(entry.path(), ignored);
    }
}

/// Started again where it has ended or doesn't answer.
void UploadServer::judge_server(bool is_silent, std::vector<std::string>& faults) {
    // A process that crashes refuses connections for a while before it has ended.
    if (is_silent && !comes_about(kEndTime, [&] { return m_server->has_ended(); }))
        (void)::kill(m_server->process(), SIGKILL);
    const std::string said = m_server->err().substr(m_said);
    m_said += said.size();
    if (!said.empty()) faults.push_back("the server said: " + printable(said, 400));
    if (!is_silent && !m_server->has_ended()) return judge_leftovers(faults);
    const Ended ended = m_server->wait();
    faults.push_back("the server ended: signal " + std::to_string(ended.signal) + ", status " +
                     std::to_string(ended.status));
    judge_leftovers(faults);
    start();
}

Outcome UploadServer::take(const Files& files, const std::string& command) {
    Outcome outcome;
    outcome.command = command;
    const auto begin = Clock::now();
    const pid_t process = m_server->process();
    reset_peak(process);
    const Answer answer = upload(files, command == kUploadFirstSeries, outcome.faults);
    outcome.ended.status = answer.status == "200" ? kTaken : kRefused;
    outcome.ended.err = answer.status + " " + answer.body;
    bool is_silent = answer.status.empty();
    if (answer.status == "200") {
        // Its voxels are used.
        Answer saved = ask("/save/volume.nrrd?token=" + m_token, nullptr);
        is_silent = saved.status.empty();
        if (saved.status == "200") saved.body = "\n";
        judge(saved, {"200"}, outcome.faults);
    }
    outcome.ended.seconds = seconds_since(begin);
    outcome.ended.peak_mb = peak_mb_of(process);
    double data_mb = 0;
    for (const File& file : files) data_mb += double(file.bytes.size()) / (1 << 20);
    if (m_judge_memory && outcome.ended.peak_mb > kMaxPeakMb + data_mb)
        outcome.faults.push_back(std::to_string(int(outcome.ended.peak_mb)) + " MB of memory");
    judge_server(is_silent, outcome.faults);
    return outcome;
}

std::vector<std::string> UploadServer::end() {
    std::vector<std::string> faults;
    (void)::kill(m_server->process(), SIGTERM);
    if (!comes_about(kEndTime, [&] { return m_server->has_ended(); })) {
        faults.push_back("the server goes on after SIGTERM");
        (void)::kill(m_server->process(), SIGKILL);
    }
    const Ended ended = m_server->wait();
    if (ended.status != 0)
        faults.push_back("the server ended: signal " + std::to_string(ended.signal) + ", status " +
                         std::to_string(ended.status));
    if (const std::string said = ended.err.substr(m_said); !said.empty())
        faults.push_back("the server said: " + printable(said, 400));
    judge_leftovers(faults);
    return faults;
}

}  // namespace pliant::mutate
