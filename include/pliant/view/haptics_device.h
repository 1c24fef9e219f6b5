/* SPDX-FileCopyrightText: 2026 The Pliant authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * Interface of a plug-in for a force-feedback device: a shared library, in C or any language with
 * extern "C", that exports pliant_haptic_device_v1(). Pliant loads it at run time, so neither needs
 * the other to be built. examples/haptic_device/ has a template, docs/method/haptics.md the rules.
 *
 * Positions are millimetres in the device's own right-handed frame: x to the user's right, y up,
 * z towards the user. Forces are newtons in the same frame.
 */
#pragma once

#ifdef __cplusplus
extern "C" {
#endif

#define PLIANT_HAPTIC_DEVICE_VERSION 1u

/* Limits of a device. Pliant stays below all of them. */
struct pliant_haptic_limits {
    double max_force_n;       /* continuous */
    double max_stiffness_n_m; /* stable in closed loop at the usual rate */
    double max_damping_n_s_m; /* stable in closed loop; 0: none */
    double workspace_mm[3];   /* width, height, depth */
};

struct pliant_haptic_pose {
    double position_mm[3];
    double orientation[4]; /* w, x, y, z of a unit quaternion; 1, 0, 0, 0 if unknown */
    unsigned buttons;      /* bit 0: the first */
};

/* All functions return 0 on success. On failure, those with a message write one line of text of at
 * most size bytes, including the terminating 0. */
struct pliant_haptic_device {
    unsigned version; /* PLIANT_HAPTIC_DEVICE_VERSION */
    unsigned size;    /* sizeof(struct pliant_haptic_device) */
    const char* name; /* "Maker Model" */

    /* which: the user's text after the plug-in's name and a colon, or "". */
    int (*open)(const char* which, void** device, char* message, unsigned size);
    int (*get_limits)(void* device, struct pliant_haptic_limits* limits);
    /* On the servo thread, once each period: no lock, no allocation, no waiting, no output. */
    int (*read)(void* device, struct pliant_haptic_pose* pose);
    int (*write)(void* device, const double force_n[3]);
    /* Ends all force. Called once, not on the servo thread. */
    void (*close)(void* device);
};

typedef const struct pliant_haptic_device* (*pliant_haptic_device_function)(void);

/* The function that a plug-in exports. The structure lives as long as the library is loaded. */
const struct pliant_haptic_device* pliant_haptic_device_v1(void);

#ifdef __cplusplus
}
#endif
