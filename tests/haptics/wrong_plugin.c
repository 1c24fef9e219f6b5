/* SPDX-FileCopyrightText: 2026 The Pliant authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * A plug-in of a version that isn't there yet.
 */
#include <pliant/view/haptics_device.h>

const struct pliant_haptic_device* pliant_haptic_device_v1(void) {
    static struct pliant_haptic_device plugin;
    plugin.version = 99;
    plugin.size = 12;
    return &plugin;
}
