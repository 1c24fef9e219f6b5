/* SPDX-FileCopyrightText: 2026 The Pliant authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * What the tests load in place of libspnav: a cap that is pushed to the right and turned, and whose
 * first button goes down. With PLIANT_FAKE_SPNAV=off its daemon doesn't run. */
#include <stdlib.h>
#include <string.h>

struct motion {
    int type, x, y, z, rx, ry, rz;
    unsigned period;
    int* data;
};
struct button {
    int type, press, bnum;
};
union event {
    int type;
    struct motion motion;
    struct button button;
};

static int is_open, told;

int spnav_open(void) {
    const char* mode = getenv("PLIANT_FAKE_SPNAV");
    if (mode && strcmp(mode, "off") == 0) return -1;
    is_open = 1;
    told = 0;
    return 0;
}

int spnav_close(void) {
    if (!is_open) abort();
    is_open = 0;
    return 0;
}

/* A motion, a button, and then nothing: the cap is held as it is. */
int spnav_poll_event(union event* event) {
    if (!is_open) abort();
    ++told;
    if (told == 1) {
        event->motion.type = 1;
        event->motion.x = 350;
        event->motion.y = 0;
        event->motion.z = 350;
        event->motion.rx = event->motion.ry = 0;
        event->motion.rz = -350;
        return 1;
    }
    if (told == 2) {
        event->button.type = 2;
        event->button.press = 1;
        event->button.bnum = 0;
        return 2;
    }
    return 0;
}
