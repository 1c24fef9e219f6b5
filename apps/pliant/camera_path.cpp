// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "camera_path.h"

#include <pliant/core/files.h>
#include <pliant/core/output_file.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace pliant::app {
namespace {

using PlainJson = nlohmann::json;

constexpr double kFineMm = 0.5;    // between the points of the smoothed path
constexpr double kSmoothMm = 3.0;  // standard deviation of the smoothing
constexpr double kAheadMm = 12.0;  // how far ahead the camera looks
constexpr double kLongestMm = 1e5;

Error wrong(const std::string& file, const std::string& what) {
    return {ErrorCode::Unreadable, file + ": " + what};
}

/// Quotes a value; invalid UTF-8 is replaced.
std::string found(const PlainJson& value) {
    return shown(value.dump(-1, ' ', false, PlainJson::error_handler_t::replace));
}

/// @returns factor of x and y that converts to LPS, 1 or −1; 0: unknown system
int lps_sign(const PlainJson& curve) {
    const PlainJson name = curve.value("coordinateSystem", PlainJson("LPS"));
    if (name == "LPS" || name == "1" || name == 1) return 1;
    if (name == "RAS" || name == "0" || name == 0) return -1;
    return 0;
}

/// A polyline parametrised by arc length.
class Polyline {
  public:
    explicit Polyline(std::vector<Vec3d> points) : m_points(std::move(points)), m_at{0} {
        for (std::size_t n = 1; n < m_points.size(); ++n)
            m_at.push_back(m_at.back() + norm(m_points[n] - m_points[n - 1]));
    }
    double length() const { return m_at.back(); }
    Vec3d operator()(double s) const {
        const auto next = std::upper_bound(m_at.begin(), m_at.end(), s);
        if (next == m_at.begin()) return m_points.front();
        if (next == m_at.end()) return m_points.back();
        const auto n = std::size_t(next - m_at.begin());
        const double share = (s - m_at[n - 1]) / (m_at[n] - m_at[n - 1]);
        return (1 - share) * m_points[n - 1] + share * m_points[n];
    }

  private:
    std::vector<Vec3d> m_points;
    std::vector<double> m_at;
};

/// Resamples and smooths: evenly spaced points, each the weighted mean of its neighbours; the ends
/// don't move.
std::vector<Vec3d> smoothed(const Polyline& line, double scale) {
    const double fine_mm = scale * kFineMm, smooth_mm = scale * kSmoothMm;
    const int count = std::max(2, int(std::ceil(line.length() / fine_mm)) + 1);
    const double step = line.length() / (count - 1);
    std::vector<Vec3d> points;
    for (int n = 0; n < count; ++n) {
        const double s = n * step;
        // Symmetric window that narrows towards the ends.
        const double reach = std::min({3 * smooth_mm, s, line.length() - s});
        const int most = int(reach / step);
        Vec3d sum{0, 0, 0};
        double weights = 0;
        for (int k = -most; k <= most; ++k) {
            const double x = k * step / smooth_mm, weight = std::exp(-0.5 * x * x);
            sum = sum + weight * line(s + k * step);
            weights += weight;
        }
        points.push_back((1 / weights) * sum);
    }
    return points;
}

}  // namespace

Result<std::vector<Vec3d>> read_camera_path(const std::string& file) {
    const Result<std::string> text =
        read_small_file(file, kMaxSmallFileBytes, "a .mrk.json of 3D Slicer");
    if (!text) return text.error();
    if (const Status s = check_nesting(*text, TextSyntax::Json); !s)
        return wrong(file, s.error().message);
    const PlainJson document = PlainJson::parse(*text, nullptr, false);
    if (document.is_discarded())
        return wrong(file, "is no JSON; expected a .mrk.json of 3D Slicer");
    if (!document.is_object() || !document.contains("markups") || !document["markups"].is_array() ||
        document["markups"].empty() || !document["markups"][0].is_object())
        return wrong(file, "markups: expected a list with a curve");
    const PlainJson& curve = document["markups"][0];
    const int sign = lps_sign(curve);
    if (sign == 0)
        return wrong(file, "coordinateSystem: expected LPS or RAS, found " +
                               found(curve["coordinateSystem"]));
    if (const PlainJson units = curve.value("coordinateUnits", PlainJson("mm"));
        units != "mm" && units != PlainJson::array({"mm", "UCUM", "millimeter"}))
        return wrong(file, "coordinateUnits: expected mm, found " + found(units));
    const PlainJson none = PlainJson::array();
    const PlainJson& all = curve.contains("controlPoints") ? curve["controlPoints"] : none;
    std::vector<Vec3d> points;
    for (std::size_t n = 0; all.is_array() && n < all.size(); ++n) {
        const PlainJson& point = all[n];
        const std::string name = "controlPoints[" + std::to_string(n) + "].position";
        if (point.is_object() && point.contains("positionStatus") &&
            point["positionStatus"] != "defined")
            continue;
        const PlainJson position =
            point.is_object() && point.contains("position") ? point["position"] : PlainJson();
        if (!position.is_array() || position.size() != 3 ||
            !std::all_of(position.begin(), position.end(),
                         [](const PlainJson& number) { return number.is_number(); }))
            return wrong(file, name + ": expected three numbers, found " + found(position));
        const Vec3d p{sign * position[0].get<double>(), sign * position[1].get<double>(),
                      position[2].get<double>()};
        if (!is_finite(p)) return wrong(file, name + ": expected finite numbers");
        if (points.empty() || norm(p - points.back()) > 1e-6) points.push_back(p);
    }
    if (points.size() < 2)
        return wrong(file, "controlPoints: expected two or more different points, found " +
                               std::to_string(points.size()));
    double length = 0;
    for (std::size_t n = 1; n < points.size(); ++n) length += norm(points[n] - points[n - 1]);
    if (!(length <= kLongestMm))
        return wrong(file, "controlPoints: expected a way of up to 100 m, found a longer one");
    return points;
}

Status write_camera_path(const std::string& file, const std::vector<Vec3d>& points_mm,
                         const std::vector<double>& radius_mm) {
    using ordered = nlohmann::ordered_json;
    const auto rounded = [](double mm) { return std::round(mm * 1e4) / 1e4; };
    ordered points = ordered::array();
    for (std::size_t n = 0; n < points_mm.size(); ++n) {
        const Vec3d p = points_mm[n];
        const std::string id = std::to_string(n + 1);
        char radius[48];
        std::snprintf(radius, sizeof radius, "radius %.2f mm", radius_mm[n]);
        points.push_back({{"id", id},
                          {"label", "way-" + id},
                          {"description", radius},
                          {"position", {rounded(p.x), rounded(p.y), rounded(p.z)}},
                          {"selected", true},
                          {"locked", false},
                          {"visibility", true},
                          {"positionStatus", "defined"}});
    }
    const ordered document = {
        {"@schema",
         "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/"
         "Resources/Schema/markups-schema-v1.0.3.json#"},
        {"markups", ordered::array({{{"type", "Curve"},
                                     {"coordinateSystem", "LPS"},
                                     {"coordinateUnits", "mm"},
                                     {"controlPoints", points}}})}};
    StagedFiles staged;
    const auto target = staged.stage(file);
    if (!target) return target.error();
    OutputFile out(*target, file);
    out.write(document.dump(1) + "\n");
    if (const Status s = out.close(); !s) return s;
    return staged.commit();
}

std::vector<CameraPose> fly(const std::vector<Vec3d>& points_mm, double step_mm, double scale) {
    const double ahead_mm = scale * kAheadMm;
    const Polyline path(smoothed(Polyline(points_mm), scale));
    std::vector<CameraPose> poses;
    Vec3d look{0, 0, 0}, up{0, 0, 0};
    const auto count = std::int64_t(std::floor(path.length() / step_mm)) + 1;
    for (std::int64_t n = 0; n < count; ++n) {
        const double s = double(n) * step_mm;
        const Vec3d eye = path(s), ahead = path(std::min(s + ahead_mm, path.length())) - eye;
        // Near the end the path ahead is too short for a direction.
        if (n == 0 || path.length() - s > 0.25 * ahead_mm)
            if (norm(ahead) > 0) look = normalized(ahead);
        if (n == 0) up = std::abs(look.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{0, -1, 0};
        up = up - dot(up, look) * look;  // parallel transport of the up vector: no roll
        if (norm(up) > 1e-9) up = normalized(up);
        poses.push_back({eye, look, up});
    }
    return poses;
}

}  // namespace pliant::app
