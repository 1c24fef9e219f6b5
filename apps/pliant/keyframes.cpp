// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "keyframes.h"

#include <pliant/core/files.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace pliant::app {
namespace {

using PlainJson = nlohmann::json;

constexpr const char* kName = "pliant keyframes";

struct Quaternion {
    double v[4];  ///< x, y, z, w
};

/// Rotation with the columns right, up and backward.
Quaternion quaternion_of(const Keyframe& frame) {
    const Vec3d forward = normalized(frame.look);
    Vec3d right = cross(forward, frame.up);
    if (!(norm(right) > 1e-6))
        right = cross(forward, std::abs(forward.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{0, -1, 0});
    right = normalized(right);
    const Mat3d m{{right, cross(right, forward), -forward}};
    const auto at = [&](int row, int column) { return m.columns[column][row]; };
    const double trace = at(0, 0) + at(1, 1) + at(2, 2);
    if (trace > 0) {
        const double r = 2 * std::sqrt(1 + trace);
        return {{(at(2, 1) - at(1, 2)) / r, (at(0, 2) - at(2, 0)) / r, (at(1, 0) - at(0, 1)) / r,
                 r / 4}};
    }
    const int i = at(0, 0) > at(1, 1) && at(0, 0) > at(2, 2) ? 0 : at(1, 1) > at(2, 2) ? 1 : 2;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double r = 2 * std::sqrt(1 + at(i, i) - at(j, j) - at(k, k));
    Quaternion q{{0, 0, 0, (at(k, j) - at(j, k)) / r}};
    q.v[i] = r / 4;
    q.v[j] = (at(j, i) + at(i, j)) / r;
    q.v[k] = (at(k, i) + at(i, k)) / r;
    return q;
}

Quaternion slerp(const Quaternion& a, const Quaternion& b, double s) {
    double cosine = 0;
    for (int n = 0; n < 4; ++n) cosine += a.v[n] * b.v[n];
    const double sign = cosine < 0 ? -1 : 1;  // the shorter arc
    const double angle = std::acos(std::min(cosine * sign, 1.0)), sine = std::sin(angle);
    const double u = sine > 1e-6 ? std::sin((1 - s) * angle) / sine : 1 - s;
    const double v = sine > 1e-6 ? std::sin(s * angle) / sine : s;
    Quaternion q{};
    double square = 0;
    for (int n = 0; n < 4; ++n) {
        q.v[n] = u * a.v[n] + v * sign * b.v[n];
        square += q.v[n] * q.v[n];
    }
    for (double& x : q.v) x /= std::sqrt(square);
    return q;
}

/// The fields of one keyframe. Keeps the first mistake.
struct Fields {
    const PlainJson& object;
    std::string where;
    std::optional<std::string> mistake{};

    double number(const char* key, double low, double high) {
        const PlainJson found =
            object.is_object() && object.contains(key) ? object[key] : PlainJson();
        const double x = found.is_number() ? found.get<double>() : NAN;
        if (!(x >= low && x <= high))
            fail(key, "a number " + PlainJson(low).dump() + "…" + PlainJson(high).dump(), found);
        return x;
    }
    Vec3d vector(const char* key, bool is_direction) {
        const PlainJson found =
            object.is_object() && object.contains(key) ? object[key] : PlainJson();
        Vec3d v{NAN, NAN, NAN};
        if (found.is_array() && found.size() == 3)
            for (std::size_t a = 0; a < 3; ++a)
                if (found[a].is_number()) v[int(a)] = found[a].get<double>();
        constexpr double kFarthest_mm = 1e6, kLeast = 1e-6;
        if (!is_finite(v))
            fail(key, "three numbers", found);
        else if (!(norm(v) <= kFarthest_mm))
            fail(key, "a length of up to 1000000", found);
        else if (is_direction && !(norm(v) >= kLeast))
            fail(key, "a direction", found);
        return v;
    }
    void fail(const std::string& key, const std::string& expected, const PlainJson& found) {
        if (!mistake)
            mistake = where + "." + key + ": expected " + expected + ", found " +
                      shown(found.dump(-1, ' ', false, PlainJson::error_handler_t::replace));
    }
};

}  // namespace

Result<std::vector<Keyframe>> read_keyframes(const std::string& file) {
    const auto wrong = [&](const std::string& what) {
        return Error{ErrorCode::Unreadable, file + ": " + what};
    };
    const Result<std::string> text =
        read_small_file(file, kMaxSmallFileBytes, "keyframes of the page");
    if (!text) return text.error();
    if (const Status s = check_nesting(*text, TextSyntax::Json); !s)
        return wrong(s.error().message);
    const PlainJson document = PlainJson::parse(*text, nullptr, false);
    if (!document.is_object()) return wrong("is no JSON object; expected keyframes of the page");
    if (document.value("what", PlainJson()) != kName)
        return wrong("what: expected \"" + std::string(kName) + "\"");
    if (document.value("version", PlainJson()) != 1) return wrong("version: expected 1");
    const PlainJson all = document.value("keyframes", PlainJson());
    if (!all.is_array() || all.empty()) return wrong("keyframes: expected a list");
    std::vector<Keyframe> frames;
    for (std::size_t n = 0; n < all.size(); ++n) {
        Fields f{all[n], "keyframes[" + std::to_string(n) + "]"};
        Keyframe frame;
        frame.seconds = f.number("seconds", 0, 36000);
        if (n == 0 ? frame.seconds != 0 : !(frame.seconds > frames.back().seconds))
            f.fail("seconds", n == 0 ? "0" : "more than before", PlainJson(frame.seconds));
        frame.eye_mm = f.vector("eye_mm", false);
        frame.look = f.vector("look", true);
        frame.up = f.vector("up", true);
        frame.field_of_view_deg = f.number("field_of_view_deg", 10, 150);
        frame.iso_hu = f.number("iso_hu", -32768, 32767);
        frame.window_hu = f.number("window_hu", 1, 65536);
        frame.level_hu = f.number("level_hu", -65536, 65536);
        if (f.mistake) return wrong(*f.mistake);
        frames.push_back(frame);
    }
    return frames;
}

Keyframe shot_at(const std::vector<Keyframe>& frames, double seconds) {
    const auto next = std::upper_bound(frames.begin(), frames.end(), seconds,
                                       [](double t, const Keyframe& f) { return t < f.seconds; });
    if (next == frames.begin() || frames.size() == 1) return frames.front();
    if (next == frames.end()) return frames.back();
    const auto i = std::size_t(next - frames.begin()) - 1, last = frames.size() - 1;
    const Keyframe &a = frames[i], &b = frames[i + 1];
    const double span = b.seconds - a.seconds, s = (seconds - a.seconds) / span;
    const auto even = [s](double x, double y) { return x + s * (y - x); };
    const auto slope = [&](std::size_t k) {
        const Keyframe &before = frames[k > 0 ? k - 1 : 0], &after = frames[std::min(k + 1, last)];
        return span / (after.seconds - before.seconds) * (after.eye_mm - before.eye_mm);
    };
    const double s2 = s * s, s3 = s2 * s;
    const auto [x, y, z, w] = slerp(quaternion_of(a), quaternion_of(b), s).v;
    return {.seconds = seconds,
            .eye_mm = (2 * s3 - 3 * s2 + 1) * a.eye_mm + (s3 - 2 * s2 + s) * slope(i) +
                      (3 * s2 - 2 * s3) * b.eye_mm + (s3 - s2) * slope(i + 1),
            .look = {-2 * (x * z + w * y), -2 * (y * z - w * x), -1 + 2 * (x * x + y * y)},
            .up = {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
            .field_of_view_deg = even(a.field_of_view_deg, b.field_of_view_deg),
            .iso_hu = even(a.iso_hu, b.iso_hu),
            .window_hu = even(a.window_hu, b.window_hu),
            .level_hu = even(a.level_hu, b.level_hu)};
}

}  // namespace pliant::app
