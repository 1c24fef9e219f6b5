// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A head for the way through the nose to the pituitary gland, the setting of [Draeger2005].
//
//      frontal sinus    ethmoid cells
//            ╲             │      ┌ sella with the gland
//        ─────●────────▒▒▒▒▒▒▒──╮●╭──
//       nose      middle turbinate │ sphenoid sinus, behind its thin bony front wall
//        ◄──── septum ─────────► ▐ ▐
//       nostril   inferior turbinate   nasopharynx
//
// Every air space has a coat of mucosa and a shell of bone around it: between two adjacent spaces,
// a thin bony wall remains. Septum and turbinates are then added to the nose.

#include "volume/phantom_bodies.h"
#include "volume/phantom_noise.h"
#include "volume/phantom_shapes.h"

namespace pliant::phantom {
namespace {

constexpr double kMucosa_mm = 0.8;
constexpr double kBone_mm = 2.1;

/// Half-width of the nose at a height.
double nose_width(double z) {
    return 14 - 4 * ramp(-14, 0, z) - 5.2 * ramp(0, 9, z) - 1.6 * ramp(9, 18, z);
}

/// Both passages; the septum divides them.
double nose(Vec3d p) {
    const double side = 0.85 * (std::abs(p.x) - nose_width(p.z));
    const double end = p.y - 5.8 - 7.7 * ramp(0, -10, p.z);
    const double height = std::max(p.z - 20 + 0.012 * (p.y + 14) * (p.y + 14), -24 - p.z);
    const double inner = smooth_intersection(side, 0.8 * height, 6);
    return smooth_intersection(inner, std::max(0.6 * end, -45 - p.y), 7);
}

double nostrils(Vec3d p) {
    return capsule(mirrored_x(p), {6, -50, -30}, {5.5, -43, -17}, 3.4, 4.4);
}

double pharynx(Vec3d p) {
    const Vec3d q{0.62 * p.x, p.y, p.z};
    const double upper = capsule(q, {0, 9, -13}, {0, 17, -17}, 6.5, 7.5);
    const double lower = capsule(q, {0, 19, -20}, {0, 23, -34}, 7, 4.6);
    return smooth_union(smooth_union(upper, lower, 4),
                        capsule(q, {0, 23, -34}, {0, 25, -70}, 4.6, 5), 3);
}

double maxillary(Vec3d p) {
    const Vec3d q = mirrored_x(p);
    const double uneven = 0.8 * value_noise(p * 0.12, 71);
    const double room = ellipsoid(q, {29.2, -22, -11}, {12.4, 17, 14.5}) + uneven;
    return smooth_union(room, capsule(q, {19, -18, -1}, {10, -17, 0}, 1.6, 1.6), 1.5);
}

double ethmoid(Vec3d p) {
    const Vec3d q = mirrored_x(p);
    double d = 1e9;
    for (int n = 0; n < 4; ++n) {
        const double y = -33 + 10.2 * n;
        d = std::min(d, ellipsoid(q, {9.8 + 0.2 * n, y, 12.5}, {3.7, 4.6, 5.2}));
        d = std::min(d, ellipsoid(q, {11.2, y + 5, 4 + 0.5 * n}, {2.4, 4.0, 2.6}));
    }
    return d + 0.3 * value_noise(p * 0.3, 72);
}

double sphenoid(Vec3d p) {
    const double left = ellipsoid(p, {7.4, 17, 5}, {6.6, 9.6, 7.6});
    const double right = ellipsoid(p, {-7.8, 16.5, 5}, {7.2, 9.0, 7.2});
    return std::min(left, right);
}

double frontal(Vec3d p) {
    return ellipsoid(mirrored_x(p), {8.2, -42.5, 32}, {7.2, 3.6, 8});
}

double air_spaces(Vec3d p) {
    return std::min({nose(p), maxillary(p), ethmoid(p), sphenoid(p), frontal(p)});
}

double septum_middle(Vec3d p) {
    return -1.5 * bump(p.y + 20, 14) * bump(p.z + 4, 12) + 0.3 * value_noise(p * 0.1, 73);
}

double septum(Vec3d p, double half_mm) {
    const double sheet = 0.9 * (std::abs(p.x - septum_middle(p)) - half_mm);
    const double end = p.y - 8 - 4 * ramp(2, -10, p.z);
    return std::max({sheet, -48 - p.y, 0.6 * end, nose(p) - 1.2});
}

double inferior_turbinate(Vec3d p) {
    const Vec3d q = mirrored_x(p);
    const double lump = 0.5 * value_noise(p * 0.22, 74);
    const double body = ellipsoid(q, {8.4, -12, -14.5}, {3.1, 24, 5.4}) + lump;
    const double stalk = box(q, {11.5, -8, -9}, {3.5, 19, 1.5}, 1.4);
    return 0.9 * smooth_union(body, stalk, 5);
}

double middle_turbinate(Vec3d p) {
    const Vec3d q = mirrored_x(p);
    const double body =
        ellipsoid(q, {6.9, -14, -1.2}, {1.8, 16, 5.2}) + 0.4 * value_noise(p * 0.25, 75);
    const double stalk = box(q, {6.6, -13, 5}, {0.8, 13, 5}, 0.6);
    return 0.9 * smooth_union(body, stalk, 1.5);
}

void add_air_spaces(LayerStack& stack) {
    const auto shell = [](Vec3d p) { return air_spaces(p) - kBone_mm; };
    stack.add([=](Vec3d p) { return std::max(shell(p), -40 - p.y); }, tissue(640, 25, 60, 3), 1.2);
    const auto breathing = [](Vec3d p) {
        return std::min({air_spaces(p), nostrils(p), pharynx(p)});
    };
    stack.add([=](Vec3d p) { return breathing(p) - kMucosa_mm; }, tissue(42, 9), 1.2);
    stack.add(breathing, uniform(kAirHu), 1.2);
}

void add_inside_nose(LayerStack& stack) {
    stack.add([](Vec3d p) { return septum(p, 1.9); }, tissue(44, 9), 1.2);
    stack.add([](Vec3d p) { return septum(p, 0.75); },
              [](Vec3d p) { return 125 + 330 * ramp(-20, -12, p.y) + 10 * value_noise(p, 76); },
              1.2);
    stack.add(inferior_turbinate, tissue(52, 9), 1.2);
    stack.add(middle_turbinate, tissue(50, 9), 1.2);
    // Conchal bone is thin and porous: it is below the bone threshold.
    stack.add(
        [](Vec3d p) {
            const Vec3d q = mirrored_x(p);
            const double curl = std::abs(ellipsoid(q, {10, -12, -13.5}, {2.6, 20, 4.4})) - 0.35;
            return std::max(curl, inferior_turbinate(p) + 1.3);
        },
        uniform(230), 1.3);
}

/// Positive in the nose's air, negative in tissue.
double room_in_nose(Vec3d p) {
    const double inside = std::min({septum(p, 1.9), inferior_turbinate(p), middle_turbinate(p)});
    return std::min(-air_spaces(p), inside);
}

/// Landmark on the visible mucosa, slightly inside the tissue.
PhantomLandmark landmark(const std::string& name, Vec3d eye, Vec3d towards, Vec3d push) {
    constexpr double kInside_mm = 0.7;
    const Vec3d look = normalized(towards - eye);
    const Vec3d wall = walk_to_surface(room_in_nose, eye, look, 80);
    return {name, wall + kInside_mm * look, push, eye, look};
}

/// The middle of the bony wall between the nose and the sphenoid sinus.
PhantomLandmark wall_landmark(const std::string& name, Vec3d eye, Vec3d towards, Vec3d push) {
    const Vec3d look = normalized(towards - eye);
    const Vec3d front = walk_to_surface(room_in_nose, eye, look, 80);
    const Vec3d back = walk_to_surface(sphenoid, front, look, 20);
    return {name, 0.5 * (front + back), push, eye, look};
}

}  // namespace

Model make_sinus_model() {
    Model model;
    model.extent_mm = {128, 128, 128};
    add_head(model.stack);
    add_air_spaces(model.stack);
    add_inside_nose(model.stack);
    model.landmarks = {landmark("septum", {5.5, -42, -3}, {0, -27, -4}, {-3, 0, 0}),
                       landmark("turbinate", {4.5, -42.5, -8}, {8, -33, -14}, {3, 2, 0}),
                       wall_landmark("sphenoid_wall", {3.5, -13, 6.5}, {4.2, 7, 6}, {0, 4, 0})};
    return model;
}

}  // namespace pliant::phantom
