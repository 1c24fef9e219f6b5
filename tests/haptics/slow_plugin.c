/* SPDX-FileCopyrightText: 2026 The Pliant authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * A device that is opened as soon as the file exists that it is given, for tests of what goes on
 * meanwhile. */
#include <pliant/view/haptics_device.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static int the_device;

static int open_device(const char* which, void** device, char* message, unsigned size) {
    int n;
    for (n = 0; n < 3000 && access(which, F_OK) != 0; ++n) usleep(10000);
    if (access(which, F_OK) != 0) {
        snprintf(message, size, "nothing came");
        return 1;
    }
    *device = &the_device;
    return 0;
}
static int get_limits(void* device, struct pliant_haptic_limits* limits) {
    (void)device;
    memset(limits, 0, sizeof *limits);
    limits->max_force_n = 3;
    limits->max_stiffness_n_m = 400;
    return 0;
}
static int read_pose(void* device, struct pliant_haptic_pose* pose) {
    (void)device;
    memset(pose, 0, sizeof *pose);
    return 0;
}
static int write_force(void* device, const double force_n[3]) {
    (void)device;
    (void)force_n;
    return 0;
}
static void close_device(void* device) {
    (void)device;
}

const struct pliant_haptic_device* pliant_haptic_device_v1(void) {
    static const struct pliant_haptic_device plugin = {PLIANT_HAPTIC_DEVICE_VERSION,
                                                       sizeof(struct pliant_haptic_device),
                                                       "slow",
                                                       open_device,
                                                       get_limits,
                                                       read_pose,
                                                       write_force,
                                                       close_device};
    return &plugin;
}
