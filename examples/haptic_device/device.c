/* SPDX-FileCopyrightText: 2026 The Pliant authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * A plug-in to begin with. Its "device" moves round a circle by itself and feels nothing; where a
 * maker's kit has to be called, a comment says so. README.md says how it is built and used.
 */
#include <math.h>
#include <pliant/view/haptics_device.h>
#include <stdio.h>
#include <string.h>

struct device {
    unsigned periods;
    double force_n[3];
};

static struct device the_device; /* kits mostly know one device at a time, too */
static int is_open;

static int open_device(const char* which, void** device, char* message, unsigned size) {
    /* Here: initialise the kit, open the device that is called `which`, calibrate it, and have it
     * render forces. Don't start the kit's own servo loop, or let it only copy pose and force. */
    if (is_open) {
        snprintf(message, size, "the example device is already open");
        return 1;
    }
    if (which[0] != 0 && strcmp(which, "circle") != 0) {
        snprintf(message, size, "expected the device 'circle', found '%s'", which);
        return 1;
    }
    is_open = 1;
    memset(&the_device, 0, sizeof the_device);
    *device = &the_device;
    return 0;
}

static int get_limits(void* device, struct pliant_haptic_limits* limits) {
    (void)device; /* Here: what the kit says, or the maker's data sheet. */
    limits->max_force_n = 3;
    limits->max_stiffness_n_m = 400;
    limits->max_damping_n_s_m = 4;
    limits->workspace_mm[0] = 160;
    limits->workspace_mm[1] = 120;
    limits->workspace_mm[2] = 70;
    return 0;
}

static int read_pose(void* device, struct pliant_haptic_pose* pose) {
    /* Here: the newest pose of the kit, without waiting for it. Millimetres; x right, y up, z
     * towards the user. */
    struct device* const d = device;
    const double angle = 0.001 * 6.283185307179586 * (double)(d->periods++ % 1000);
    pose->position_mm[0] = 10 * cos(angle);
    pose->position_mm[1] = 10 * sin(angle);
    pose->position_mm[2] = 0;
    pose->orientation[0] = 1;
    pose->orientation[1] = pose->orientation[2] = pose->orientation[3] = 0;
    pose->buttons = 0;
    return 0;
}

static int write_force(void* device, const double force_n[3]) {
    /* Here: hand the force to the kit. */
    memcpy(((struct device*)device)->force_n, force_n, 3 * sizeof(double));
    return 0;
}

static void close_device(void* device) {
    (void)device; /* Here: no force, then close. */
    is_open = 0;
}

const struct pliant_haptic_device* pliant_haptic_device_v1(void) {
    static const struct pliant_haptic_device plugin = {
        PLIANT_HAPTIC_DEVICE_VERSION, sizeof(struct pliant_haptic_device),
        "example circle",             open_device,
        get_limits,                   read_pose,
        write_force,                  close_device};
    return &plugin;
}
