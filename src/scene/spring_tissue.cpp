// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "scene/spring_tissue.h"

#include <pliant/staged_files.h>

#include <bit>
#include <fstream>
#include <span>

#include "core/hash.h"

namespace pliant {
namespace {

constexpr std::size_t kMaxSteps = 200, kMaxBytes = 256'000'000;
constexpr std::uint64_t kMagic = 0x31'70'73'6c'70'00'00'0a;  ///< of a file with a state

std::uint64_t checksum_of(std::span<const Vec3d> places) {
    Hash64 hash;
    hash.add_word(places.size());
    for (const Vec3d p : places)
        for (int a = 0; a < 3; ++a) hash.add_word(std::bit_cast<std::uint64_t>(p[a]));
    return hash.value();
}

void write_word(std::ostream& stream, std::uint64_t word) {
    char bytes[8];
    for (int k = 0; k < 8; ++k) bytes[k] = char(word >> 8 * k & 0xff);
    stream.write(bytes, 8);
}
std::uint64_t read_word(std::istream& stream) {
    unsigned char bytes[8] = {};
    stream.read(reinterpret_cast<char*>(bytes), 8);
    std::uint64_t word = 0;
    for (int k = 0; k < 8; ++k) word |= std::uint64_t(bytes[k]) << 8 * k;
    return word;
}

}  // namespace

Result<PushReport> SpringScanTissue::push(std::uint32_t tool, const Push& push) {
    return m_model->push(tool, push);
}

Result<GrabReport> SpringScanTissue::grab(std::uint32_t tool, const Push& place, double) {
    m_drag.reset();
    Push still = place;
    still.push_mm = {0, 0, 0};
    const auto report = m_model->push(tool, still);
    if (!report.ok()) return report.error();
    if (report->grabbed_elements > 0) m_drag = Drag{tool, still, {0, 0, 0}};
    return GrabReport{.grabbed_elements = report->grabbed_elements,
                      .pick_ms = report->solve_ms,
                      .message = report->message};
}

Result<PushReport> SpringScanTissue::drag_to(Vec3d offset_mm) {
    if (!m_drag) return Error{ErrorCode::InvalidArgument, "drag: expected a grab before it"};
    Push push = m_drag->place;
    push.point_mm = push.point_mm + m_drag->done_mm;
    push.push_mm = offset_mm - m_drag->done_mm;
    auto report = m_model->push(m_drag->tool, push);
    if (report.ok()) m_drag->done_mm = m_drag->done_mm + report->step_fraction * push.push_mm;
    return report;
}

void SpringScanTissue::let_go() {
    if (m_drag) m_model->let_go(m_drag->tool);
    m_drag.reset();
}

Sweep SpringScanTissue::sweep() {
    const SpringMotion motion = m_model->step(kStepsPerSweep);
    if (motion.active_nodes > 0) m_active_nodes = motion.active_nodes;
    return {motion.settled, motion.solve_ms};
}

void SpringScanTissue::begin_group(const std::string&) {
    m_before = m_model->places_mm();
}

int SpringScanTissue::end_group() {
    if (!m_before || *m_before == m_model->places_mm()) return 0;
    m_undone.clear();
    m_done.push_back(std::move(*m_before));
    m_before.reset();
    int forgotten = 0;
    const std::size_t bytes = m_done.back().size() * sizeof(Vec3d);
    while (m_done.size() > kMaxSteps || m_done.size() * bytes > kMaxBytes) {
        m_done.pop_front();
        ++forgotten;
    }
    return m_done.empty() ? -1 : forgotten;
}

Status SpringScanTissue::undo() {
    if (m_done.empty()) return Error{ErrorCode::NotFound, "undo: expected a step, found none"};
    m_undone.push_back(m_model->places_mm());
    const Places places = std::move(m_done.back());
    m_done.pop_back();
    return m_model->set_places(places);
}

Status SpringScanTissue::redo() {
    if (m_undone.empty()) return Error{ErrorCode::NotFound, "redo: expected a step, found none"};
    m_done.push_back(m_model->places_mm());
    const Places places = std::move(m_undone.back());
    m_undone.pop_back();
    return m_model->set_places(places);
}

Status SpringScanTissue::save_state(const std::filesystem::path& path) const {
    StagedFiles files;
    const auto staged = files.stage(path);
    if (!staged.ok()) return staged.error();
    const Places places = m_model->places_mm();
    std::ofstream stream(*staged, std::ios::binary);
    write_word(stream, kMagic);
    write_word(stream, places.size());
    for (const Vec3d p : places)
        for (int a = 0; a < 3; ++a) write_word(stream, std::bit_cast<std::uint64_t>(p[a]));
    write_word(stream, checksum_of(places));
    stream.close();
    if (!stream)
        return Error{ErrorCode::Unwritable, path.filename().string() + ": can't be written"};
    return files.commit();
}

Status SpringScanTissue::load_state(const std::filesystem::path& path) {
    const auto wrong = [&](const char* what) -> Status {
        return Error{ErrorCode::Unreadable, path.filename().string() + ": " + what};
    };
    std::ifstream stream(path, std::ios::binary);
    if (!stream) return wrong("expected a file, found none");
    if (read_word(stream) != kMagic) return wrong("expected a state of springs");
    const auto count = std::size_t(m_model->control().node_count());
    if (read_word(stream) != count) return wrong("expected the places of as many control nodes");
    Places places(count);
    for (Vec3d& p : places)
        for (int a = 0; a < 3; ++a) p[a] = std::bit_cast<double>(read_word(stream));
    const std::uint64_t checksum = read_word(stream);
    if (!stream || checksum != checksum_of(places)) return wrong("damaged or cut short");
    m_done.clear();
    m_undone.clear();
    return m_model->set_places(places);
}

}  // namespace pliant
