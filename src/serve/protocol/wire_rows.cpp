// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "protocol/wire_rows.h"

#include "protocol/limits.h"

namespace pliant::serve {
namespace {

constexpr Setting<TissueChoice> kTissue[] = {
    setting<&TissueChoice::nodes>({.name = "nodes",
                                   .range = {3, 64},
                                   .text = "control nodes along each axis, or as many as the scan "
                                           "has room for"}),
    setting<&TissueChoice::depth_by_time>(
        {.name = "depth_by_time",
         .text =
             "the server lowers or raises the depth so that motion keeps its pace, and slow lines "
             "their updates"}),
};

constexpr Setting<IsoCommand> kIso[] = {
    setting<&IsoCommand::iso_hu>({.name = "iso_hu",
                                  .unit = "HU",
                                  .range = {-kMaxThreshold, kMaxThreshold},
                                  .text = "threshold of the visible surface"}),
    setting<&IsoCommand::polarity>(
        {.name = "polarity",
         .choices = "rising|falling",
         .text = "rising: tissue is brighter than the lumen; falling: darker"}),
};

constexpr Setting<DepthCommand> kDepth[] = {
    setting<&DepthCommand::layers>({.name = "layers",
                                    .unit = "layers",
                                    .range = {0, kMaxDepthLayers},
                                    .text = "layers beyond the contact that move"}),
    setting<&DepthCommand::within_mm>(
        {.name = "within_mm",
         .unit = "mm",
         .range = {0, 1000},
         .above_low = true,
         .text = "instead of layers: the smallest number for which one more moves no node of the "
                 "present contacts by more than this"}),
    setting<&DepthCommand::by_time>({.name = "by_time",
                                     .text = "as depth_by_time of the tissue; other commands end "
                                             "it"}),
};

constexpr Setting<DriveCommand> kDrive[] = {
    setting<&DriveCommand::insert_mm_s>({.name = "insert_mm_s",
                                         .unit = "mm/s",
                                         .range = {-kMaxInsert_mm_s, kMaxInsert_mm_s},
                                         .text = "speed of the insertion"}),
    setting<&DriveCommand::rotate_deg_s>({.name = "rotate_deg_s",
                                          .unit = "degrees/s",
                                          .range = {-kMaxRotate_deg_s, kMaxRotate_deg_s},
                                          .text = "speed of the rotation"}),
    setting<&DriveCommand::bend_first_deg>({.name = "bend_first_deg",
                                            .unit = "degrees",
                                            .range = {-kMaxBend_deg, kMaxBend_deg},
                                            .text = "bend of the tip about its first axis"}),
    setting<&DriveCommand::bend_second_deg>({.name = "bend_second_deg",
                                             .unit = "degrees",
                                             .range = {-kMaxBend_deg, kMaxBend_deg},
                                             .text = "bend of the tip about its second axis"}),
};

}  // namespace

SettingRows<TissueChoice> tissue_rows() noexcept {
    return kTissue;
}
SettingRows<IsoCommand> iso_rows() noexcept {
    return kIso;
}
SettingRows<DepthCommand> depth_rows() noexcept {
    return kDepth;
}
SettingRows<DriveCommand> drive_rows() noexcept {
    return kDrive;
}

}  // namespace pliant::serve
