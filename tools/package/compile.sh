#!/bin/sh
# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# A hook of mmdebstrap: makes the packages in a new system that has the sources in /pliant. Root's
# ccache is mounted for as long as this runs.

set -eu
system=$1
export HOME=/root LC_ALL=C.UTF-8
unset LANG LANGUAGE # ccache's objects depend on them
[ ! -d "$system/pliant/viewer/dist" ] || touch "$system/pliant/viewer/dist/licenses.txt" # as it is
if [ -n "$PLIANT_CCACHE" ]; then
    mkdir "$system/ccache"
    export CCACHE_DIR=/ccache
    # shellcheck disable=SC2016  # expanded by the inner shell
    exec unshare --mount sh -euc \
        'mount --bind "$PLIANT_CCACHE" "$1/ccache"; exec chroot "$1" /pliant/dev package' \
        sh "$system"
fi
exec chroot "$system" /pliant/dev package
