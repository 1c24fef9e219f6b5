# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root and called_from come from ./dev
#
# How the scripts speak: progress on standard output, one line on standard error before they stop.

say() {
    printf '\n== %s\n' "$*"
}

fail() {
    printf 'dev: %s\n' "$*" >&2
    exit 1
}
