/* SPDX-FileCopyrightText: 2026 The Pliant authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * What a plug-in for a force-feedback device is: a shared library, in C or anything that can say
 * extern "C", that exports pliant_haptic_device_v1(). Pliant loads it at run time, so neither needs
 * the other to be built. examples/haptic_device/ has one to begin with; docs/haptics.md the rules.
 *
 * Positions are millimetres in the device's own right-handed frame: x to the user's right, y up,
 * z towards the user. Forces are newtons in the same frame.
 */
#pragma once

#ifdef __cplusplus
extern "C" {
#endif

#define PLIANT_HAPTIC_DEVICE_VERSION 1u

/* What the device can take. Pliant stays below all of it. */
struct pliant_haptic_limits {
    double max_force_n;       /* that it can hold */
    double max_stiffness_n_m; /* that is stable in closed loop at its usual rate */
    double max_damping_n_s_m; /* likewise; 0: none */
    double workspace_mm[3];   /* width, height, depth */
};

struct pliant_haptic_pose {
    double position_mm[3];
    double orientation[4]; /* w, x, y, z of a unit quaternion; 1, 0, 0, 0 where it isn't known */
    unsigned buttons;      /* bit 0: the first */
};

/* All functions return 0 where all is well. Those with a message write one line of text, at most
 * size bytes with the 0 at its end, where they don't. */
struct pliant_haptic_device {
    unsigned version; /* PLIANT_HAPTIC_DEVICE_VERSION */
    unsigned size;    /* sizeof(struct pliant_haptic_device) */
    const char* name; /* "Maker Model" */

    /* which: what the user wrote after the plug-in's name and a colon, or "". */
    int (*open)(const char* which, void** device, char* message, unsigned size);
    int (*get_limits)(void* device, struct pliant_haptic_limits* limits);
    /* On the servo thread, once each period: no lock, no allocation, no waiting, no output. */
    int (*read)(void* device, struct pliant_haptic_pose* pose);
    int (*write)(void* device, const double force_n[3]);
    /* Ends all force. Called once, not on the servo thread. */
    void (*close)(void* device);
};

typedef const struct pliant_haptic_device* (*pliant_haptic_device_function)(void);

/* What a plug-in exports. The structure lives as long as the library is loaded. */
const struct pliant_haptic_device* pliant_haptic_device_v1(void);

#ifdef __cplusplus
}
#endif
