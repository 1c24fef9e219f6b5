// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rows of the settings of a catheter in a vessel, and of scene files.

#include <pliant/models/catheter.h>

namespace pliant {
namespace {

using C = CatheterSettings;
using Shape = CatheterShape;
using V = VesselFile;
using A = VesselAct;

constexpr Setting<C> kCatheterRows[] = {
    setting<&C::catheter, &Shape::length_mm>(
        {.name = "length_mm", .unit = "mm", .range = {10, 3000}, .text = "length"}),
    setting<&C::catheter, &Shape::segment_mm>(
        {.name = "segment_mm", .unit = "mm", .range = {0.2, 20}, .text = "length of a segment"}),
    setting<&C::catheter, &Shape::radius_mm>(
        {.name = "radius_mm", .unit = "mm", .range = {0.1, 5}, .text = "outer radius"}),
    setting<&C::catheter, &Shape::bend_n_mm2>({.name = "bend_n_mm2",
                                               .unit = "N mm²",
                                               .range = {1e-3, 1e4},
                                               .text = "bending stiffness EI of the shaft"}),
    setting<&C::catheter, &Shape::twist_n_mm2>({.name = "twist_n_mm2",
                                                .unit = "N mm²",
                                                .range = {1e-3, 1e4},
                                                .text = "torsional stiffness GJ"}),
    setting<&C::catheter, &Shape::tip_mm>({.name = "tip_mm",
                                           .unit = "mm",
                                           .range = {0, 3000},
                                           .text = "length of the tip, which steering bends"}),
    setting<&C::catheter, &Shape::tip_bend_n_mm2>({.name = "tip_bend_n_mm2",
                                                   .unit = "N mm²",
                                                   .range = {1e-3, 1e4},
                                                   .text = "bending stiffness of the tip"}),
    setting<&C::catheter, &Shape::mass_g_mm>(
        {.name = "mass_g_mm", .unit = "g/mm", .range = {1e-5, 1}, .text = "mass for a length"}),
    setting<&C::catheter, &Shape::damping_per_s>(
        {.name = "damping_per_s",
         .unit = "1/s",
         .range = {0, 1000},
         .text = "rate at which free motion of the wire dies away"}),
    setting<&C::catheter, &Shape::friction>(
        {.name = "friction", .range = {0, 2}, .text = "Coulomb's coefficient on the wall"}),
    setting<&C::catheter, &Shape::contact_mm_per_n>(
        {.name = "contact_mm_per_n",
         .unit = "mm/N",
         .range = {0, 10},
         .text = "compliance of a contact's surfaces; 0: 10 mm³ / EI, at most 0.1"}),
};
constexpr Setting<C> kWallRows[] = {
    setting<&C::wall, &WallTissue::model>({.key = "model",
                                           .name = "wall_model",
                                           .choices = "solid|distances|rigid",
                                           .text = "neo-Hookean tetrahedra, the constraints "
                                                   "below, or a wall that doesn't move"}),
    setting<&C::wall, &WallTissue::stretch_stiffness>(
        {.name = "stretch_stiffness",
         .range = {0, 1},
         .text = "of distances: share of an edge's error that a sub-step removes"}),
    setting<&C::wall, &WallTissue::bend_stiffness>(
        {.name = "bend_stiffness",
         .range = {0, 1},
         .text = "the same of the angle between two faces of the surface"}),
    setting<&C::wall, &WallTissue::volume_stiffness>({.name = "volume_stiffness",
                                                      .range = {0, 1},
                                                      .text = "the same of a tetrahedron's "
                                                              "volume"}),
    setting<&C::wall, &WallTissue::gravity_mm_s2>(
        {.name = "gravity_mm_s2", .unit = "mm/s², LPS", .text = "acceleration of the wall"}),
    setting<&C::wall, &WallTissue::young_modulus_pa>({.name = "young_modulus_pa",
                                                      .unit = "Pa",
                                                      .range = {1e3, 1e8},
                                                      .text = "Young's modulus of a solid"}),
    setting<&C::wall, &WallTissue::poisson_ratio>(
        {.name = "poisson_ratio", .range = {0.01, 0.499}, .text = "Poisson's ratio of a solid"}),
    setting<&C::wall, &WallTissue::iterations>(
        {.key = "iterations",
         .name = "wall_iterations",
         .range = {1, 100},
         .text = "visits of each constraint of the wall in a sub-step"}),
    setting<&C::wall, &WallTissue::alternates>(
        {.name = "alternates",
         .text = "every second visit goes through them in the opposite order; iterations must "
                 "be even"}),
    setting<&C::wall, &WallTissue::density_g_mm3>(
        {.name = "density_g_mm3",
         .unit = "g/mm³",
         .range = {1e-4, 10},
         .text = "density, with the blood and tissue that move along"}),
    setting<&C::wall, &WallTissue::support_pa_per_mm>(
        {.name = "support_pa_per_mm",
         .unit = "Pa/mm",
         .range = {0, 1e6},
         .text = "stiffness of the tissue around: pressure for a displacement"}),
    setting<&C::wall, &WallTissue::damping_per_s>(
        {.key = "damping_per_s",
         .name = "wall_damping_per_s",
         .unit = "1/s",
         .range = {0, 1000},
         .text = "rate at which free motion of the wall dies away"}),
};
constexpr Setting<C> kEntryRows[] = {
    setting<&C::entry, &CatheterEntry::inserted_mm>({.name = "inserted_mm",
                                                     .unit = "mm",
                                                     .range = {0, 3000},
                                                     .text = "length inserted at first"}),
    setting<&C::entry, &CatheterEntry::position_mm>(
        {.name = "place_mm",
         .unit = "mm, LPS",
         .text = "where the guide ends, instead of an open end"}),
    setting<&C::entry, &CatheterEntry::direction>(
        {.name = "direction", .text = "into the vessel, beside place_mm"}),
};
constexpr Setting<C> kSimulationRows[] = {
    setting<&C::local>({.name = "local", .text = "only boxes of the wall near the catheter move"}),
    setting<&C::box_mm>(
        {.name = "box_mm", .unit = "mm", .range = {1, 1000}, .text = "edge of these boxes"}),
    setting<&C::reach_mm>({.name = "reach_mm",
                           .unit = "mm",
                           .range = {-1, 1000},
                           .text = "boxes this near to the catheter move; -1: from the wall's "
                                   "stiffness"}),
    setting<&C::time_step_s>(
        {.name = "time_step_s", .unit = "s", .range = {1e-5, 0.05}, .text = "time step"}),
    setting<&C::sub_steps>(
        {.name = "sub_steps", .range = {1, 1000}, .text = "sub-steps of a step, at least"}),
    setting<&C::iterations>({.name = "iterations",
                             .range = {1, 100},
                             .text = "Newton iterations of the wire in each sub-step"}),
};
constexpr auto kCatheter =
    joined(in_table("catheter", kCatheterRows), in_table("wall", kWallRows),
           in_table("entry", kEntryRows), in_table("simulation", kSimulationRows));

constexpr Setting<V> kVesselRows[] = {
    setting<&V::phantom>({.name = "phantom",
                          .choices = "bend|arch|aorta",
                          .text = "a tube made by the program, or an aorta with "
                                  "the arteries of its arch"}),
    setting<&V::mesh>({.name = "mesh", .text = "file of a wall's tetrahedra"}),
    setting<&V::ghost>({.name = "ghost",
                        .text = "file of the inner surface, beside mesh; none: the part of the "
                                "boundary between sharp rims"}),
    setting<&V::surface>({.name = "surface", .text = "file of a surface"}),
    setting<&V::centreline>({.name = "centreline", .text = "file of a centreline with radii"}),
    setting<&V::labels_file>(
        {.key = "label_volume", .name = "labels_file", .text = "file of a label map"}),
    setting<&V::scan>({.name = "scan", .text = "file of a scan"}),
    setting<&V::labels>({.name = "labels",
                         .range = {-2147483648.0, 2147483647.0},
                         .text = "labels of the lumen, beside label_volume"}),
    Setting<V>{{.name = "window_hu",
                .unit = "HU",
                .count = 2,
                .text = "lowest and highest value of the lumen, beside scan",
                .kind = SettingKind::Numbers},
               [](const V& v) -> SettingValue {
                   return std::vector<double>{v.low_hu, v.high_hu};
               },
               [](V& v, const SettingValue& value) {
                   const auto& window = *std::get_if<std::vector<double>>(&value);
                   v.low_hu = window[0];
                   v.high_hu = window[1];
               }},
    setting<&V::ends>(
        {.name = "ends", .text = "file of a centreline at whose ends a closed surface is cut off"}),
    setting<&V::trim>({.name = "trim",
                       .unit = "radii",
                       .range = {0, 100},
                       .text = "length that is cut off there"}),
    setting<&V::within_mm>({.name = "within_mm",
                            .unit = "mm",
                            .range = {0.1, 1000},
                            .text = "distance from the way through a scan that belongs to the "
                                    "vessel"}),
    setting<&V::smoothing_voxels>({.name = "smoothing_voxels",
                                   .unit = "voxels",
                                   .range = {0, 20},
                                   .text = "standard deviation of the smoothing of labels"}),
    setting<&V::wall, &WallSettings::thickness_mm>({.name = "thickness_mm",
                                                    .unit = "mm",
                                                    .range = {0.01, 100},
                                                    .text = "thickness of the wall"}),
    setting<&V::wall, &WallSettings::cell_mm>({.name = "cell_mm",
                                               .unit = "mm",
                                               .range = {0, 100},
                                               .text = "cell of the mesher's lattice; 0: as the "
                                                       "layers allow"}),
    setting<&V::wall, &WallSettings::layers>(
        {.name = "layers", .range = {1, 16}, .text = "tetrahedra across the wall, at least"}),
};
constexpr Setting<V> kWayRows[] = {
    setting<&V::way_file>(
        {.key = "file", .name = "way_file", .text = "file of a centreline to steer along"}),
    setting<&V::way_branch>(
        {.key = "branch", .name = "way_branch", .range = {1, 1e6}, .text = "number of its branch"}),
    setting<&V::way_reverse>(
        {.key = "reverse", .name = "way_reverse", .text = "from its end to its beginning"}),
    setting<&V::way_mm>({.key = "points_mm",
                         .name = "way_mm",
                         .unit = "mm, LPS",
                         .text = "points of the way; in a scan or label map, its two ends"}),
    setting<&V::ahead_mm>({.name = "ahead_mm",
                           .unit = "mm",
                           .range = {0.1, 1000},
                           .text = "distance ahead that steering aims at"}),
    setting<&V::gain>({.name = "gain", .range = {0, 100}, .text = "of the steering"}),
    setting<&V::max_deg>({.name = "max_deg",
                          .unit = "degrees",
                          .range = {0, 360},
                          .text = "largest bend of the steered tip"}),
};
constexpr Setting<V> kFileEntryRows[] = {
    setting<&V::entry_end>({.key = "end",
                            .name = "entry_end",
                            .range = {1, 1e6},
                            .text = "number of the open end, as pliant mesh lists them"}),
    setting<&V::entry_inwards>({.key = "inwards",
                                .name = "entry_inwards",
                                .unit = "radii",
                                .range = {-10, 10},
                                .text = "distance of the guide's end from it"}),
};
constexpr Setting<V> kFileSimulationRows[] = {
    setting<&V::max_steps>({.name = "max_steps",
                            .range = {1, double(kMaxVesselSteps)},
                            .text = "largest number of steps of the script"}),
};
constexpr auto kFile =
    joined(in_table("vessel", kVesselRows), in_table("way", kWayRows),
           in_table("entry", kFileEntryRows), in_table("simulation", kFileSimulationRows));

constexpr Setting<A> kScriptRows[] = {
    setting<&A::command, &CatheterCommand::insert_mm_s>({.name = "insert_mm_s",
                                                         .unit = "mm/s",
                                                         .range = {-1000, 1000},
                                                         .text = "speed of the insertion"}),
    setting<&A::command, &CatheterCommand::rotate_deg_s>({.name = "rotate_deg_s",
                                                          .unit = "degrees/s",
                                                          .range = {-36000, 36000},
                                                          .text = "speed of the rotation"}),
    Setting<A>{{.name = "bend_deg",
                .unit = "degrees",
                .count = 2,
                .text = "bend of the tip about its two axes",
                .kind = SettingKind::Numbers},
               [](const A& a) -> SettingValue {
                   return std::vector<double>{a.command.bend_first_deg, a.command.bend_second_deg};
               },
               [](A& a, const SettingValue& value) {
                   const auto& bend = *std::get_if<std::vector<double>>(&value);
                   a.command.bend_first_deg = bend[0];
                   a.command.bend_second_deg = bend[1];
               }},
    setting<&A::follow>({.name = "follow", .text = "the tip is steered along the way"}),
    setting<&A::for_s>({.name = "for_s", .unit = "s", .range = {0, 1e6}, .text = "duration"}),
    setting<&A::until_inserted_mm>({.name = "until_inserted_mm",
                                    .unit = "mm",
                                    .range = {0, 1e6},
                                    .text = "until so much is inserted"}),
    setting<&A::until_way_mm>({.name = "until_way_mm",
                               .unit = "mm",
                               .range = {0, 1e6},
                               .text = "until the tip has come so far along the way"}),
};
constexpr auto kAct = in_table("script", kScriptRows);

}  // namespace

SettingRows<CatheterSettings> catheter_rows() noexcept {
    return kCatheter;
}
SettingRows<VesselFile> vessel_file_rows() noexcept {
    return kFile;
}
SettingRows<VesselAct> vessel_act_rows() noexcept {
    return kAct;
}

}  // namespace pliant
