// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "vessel_outputs.h"

#include <pliant/core/files.h>
#include <pliant/mesh_files.h>
#include <pliant/models/catheter.h>
#include <pliant/view/png.h>
#include <pliant/view/surface_view.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <system_error>

#include "output_text.h"

namespace pliant::app {
namespace {

constexpr const char* kLogBegins = "pliant vessel log 1";

std::string joined_numbers(std::initializer_list<double> values, char between) {
    std::string line;
    for (const double value : values) {
        if (!line.empty()) line += between;
        line += exact(value);
    }
    return line;
}

bool parse(const std::string& word, double& out) {
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
    return error == std::errc() && end == word.data() + word.size() && std::isfinite(out);
}

/// The smallest of 1, 2, 3 and 5 times a power of ten that isn't exceeded, at least a micrometre.
double full_scale(double largest) {
    const double power = std::pow(10, std::floor(std::log10(std::max(largest, 1e-3))));
    for (const double factor : {1.0, 2.0, 3.0, 5.0})
        if (largest <= factor * power) return factor * power;
    return 10 * power;
}

}  // namespace

std::string exact(double value) {
    char text[40];
    const auto end = std::to_chars(text, text + sizeof(text), value);
    return {text, end.ptr};
}

Status TextFile::open(const std::string& file, StagedFiles& staged) {
    const auto path = staged.stage(file);
    if (!path) return path.error();
    return m_out.emplace(*path, file).status();
}
Status TextFile::close() {
    return m_out->close();
}

std::string csv_names() {
    return "step,time_s,inserted_mm,rotated_deg,force_n,torque_n_mm,contact_n,depth_mm,"
           "wire_energy_mj,active_tetrahedra";
}
std::string csv_line(const CatheterMeasures& m) {
    return std::to_string(m.steps) + ',' +
           joined_numbers({m.time_s, m.inserted_mm, m.rotated_deg, m.force_n, m.torque_n_mm,
                           m.contact_n, m.depth_mm, m.wire_energy_mj},
                          ',') +
           ',' + std::to_string(m.active_tetrahedra);
}

Status Frames::open(const std::string& folder, StagedFiles& staged) {
    const auto place = staged.stage_folder(folder);
    if (!place) return place.error();
    m_folder = *place;
    return Ok{};
}

Status Frames::add(const CatheterScene& scene) {
    char number[16];
    std::snprintf(number, sizeof(number), "_%05zu", m_wall.size());
    const double time = scene.quick_measures().time_s;
    const auto name = [&](const char* what, const char* ending) {
        return std::string(what) + number + ending;
    };
    const auto positions = scene.wall_positions();
    std::vector<Vec3d> moved = positions;
    for (std::size_t n = 0; n < moved.size(); ++n)
        moved[n] = positions[n] - scene.wall().mesh.nodes_mm[n];
    const TetMesh wall{positions, scene.wall().mesh.cells};
    const TriangleMesh ghost{scene.ghost_positions(), scene.wall().ghost.cells};
    m_wall.push_back({time, name("wall", ".vtu")});
    m_ghost.push_back({time, name("ghost", ".vtp")});
    m_catheter.push_back({time, name("catheter", ".vtp")});
    if (const Status s = write_vtu(m_folder / m_wall.back().file, wall,
                                   {.node_vectors = {{"displacement_mm", moved}}});
        !s)
        return s;
    if (const Status s = write_surface(m_folder / m_ghost.back().file, ghost); !s) return s;
    const auto wire = scene.wire_positions();
    const auto first = std::size_t(scene.first_inserted());
    const std::vector<Vec3d> inside(wire.begin() + std::ptrdiff_t(first), wire.end());
    std::vector<std::int32_t> line;
    for (std::size_t n = 0; n < inside.size(); ++n) line.push_back(std::int32_t(n));
    return write_lines(m_folder / m_catheter.back().file, inside, {&line, 1});
}

Status Frames::close() {
    if (const Status s = write_pvd(m_folder / "wall.pvd", m_wall); !s) return s;
    if (const Status s = write_pvd(m_folder / "ghost.pvd", m_ghost); !s) return s;
    return write_pvd(m_folder / "catheter.pvd", m_catheter);
}

Status write_vessel_picture(const std::filesystem::path& path, const CatheterScene& scene) {
    const TriangleMesh& rest = scene.wall().ghost;
    const std::vector<Vec3d> ghost = scene.ghost_positions();
    std::vector<double> moved_mm;
    double largest_mm = 0;
    for (std::size_t n = 0; n < ghost.size(); ++n) {
        moved_mm.push_back(norm(ghost[n] - rest.nodes_mm[n]));
        largest_mm = std::max(largest_mm, moved_mm.back());
    }
    const DrawnSurface wall{
        .nodes_mm = ghost, .triangles = rest.cells, .values = moved_mm, .opacity = 0.6};
    const DrawnWire wire{
        .points_mm = scene.wire_positions().subspan(std::size_t(scene.first_inserted())),
        .radius_mm = scene.settings().catheter.radius_mm};
    const SurfaceView view{.full = full_scale(largest_mm),
                           .scale = "displacement of the inner wall [mm]"};
    constexpr int kWidth = 1200, kHeight = 900;
    return write_png(path, surface_view({&wall, 1}, {&wire, 1}, view, kWidth, kHeight));
}

Status write_log(const std::string& file, const HandLog& log) {
    StagedFiles staged;
    TextFile out;
    if (const Status s = out.open(file, staged); !s) return s;
    out.line(kLogBegins);
    for (const HandLog::Line& l : log.lines)
        out.line(std::to_string(l.step) + ' ' +
                 joined_numbers({l.command.insert_mm_s, l.command.rotate_deg_s,
                                 l.command.bend_first_deg, l.command.bend_second_deg},
                                ' '));
    out.line("end " + std::to_string(log.steps) + ' ' + hex_of(log.hash));
    if (const Status s = out.close(); !s) return s;
    return staged.commit();
}

Result<HandLog> read_log(const std::string& file) {
    const Result<std::string> all = read_small_file(file, kMaxSmallFileBytes, "a log of the hand");
    if (!all) return all.error();
    std::istringstream in(*all);
    const auto wrong = [&](int line, const std::string& what) {
        return Error{ErrorCode::InvalidArgument,
                     file + ": line " + std::to_string(line) + ": " + what};
    };
    std::string text;
    if (!std::getline(in, text) || text != kLogBegins)
        return wrong(1, "expected \"" + std::string(kLogBegins) + "\"");
    const auto too_long = [&](int line, double step) {
        return wrong(line,
                     "step " + exact(step) + ", expected up to " + std::to_string(kMaxVesselSteps));
    };
    HandLog log;
    for (int number = 2; std::getline(in, text); ++number) {
        std::istringstream words(text);
        std::vector<std::string> word;
        for (std::string w; words >> w;) word.push_back(w);
        double step = 0;
        if (word.size() == 3 && word[0] == "end") {
            const auto [end, error] =
                std::from_chars(word[2].data(), word[2].data() + word[2].size(), log.hash, 16);
            if (!parse(word[1], step) || !(step >= 0) || error != std::errc() ||
                end != word[2].data() + word[2].size())
                return wrong(number, "expected end, a number of steps and a checksum");
            if (step > double(kMaxVesselSteps)) return too_long(number, step);
            log.steps = std::int64_t(step);
            return log;
        }
        HandLog::Line line{};
        CatheterCommand& c = line.command;
        if (word.size() != 5 || !parse(word[0], step) || !(step >= 0) ||
            !parse(word[1], c.insert_mm_s) || !parse(word[2], c.rotate_deg_s) ||
            !parse(word[3], c.bend_first_deg) || !parse(word[4], c.bend_second_deg))
            return wrong(number, "expected a step and four numbers, found \"" + shown(text) + "\"");
        if (step > double(kMaxVesselSteps)) return too_long(number, step);
        line.step = std::int64_t(step);
        if (!log.lines.empty() && line.step <= log.lines.back().step)
            return wrong(number, "expected steps in rising order");
        log.lines.push_back(line);
    }
    return Error{ErrorCode::InvalidArgument, file + ": ends without a line \"end …\""};
}

}  // namespace pliant::app
