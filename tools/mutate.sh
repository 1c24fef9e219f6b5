# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root and called_from come from ./dev
#
# `./dev mutate`: the program on damaged files of every format that it reads, as many as wanted.
# Inputs that it doesn't take or refuse as it should are kept in build/mutate-found.

mutate() { # [FORMAT…] [--count N] [--seed S] [--first N] [--sanitize]
    local preset=gcc found=$root/build/mutate-found arguments=(--count 2000) formats=()
    while (($#)); do
        case $1 in
            --count | --seed | --first)
                [[ ${2:-} =~ ^[0-9]+$ ]] || fail "mutate: $1: expected a number"
                arguments+=("$1" "$2")
                shift
                ;;
            --sanitize)
                preset=asan
                arguments+=(--no-limits)
                ;;
            -*) fail "mutate: expected --count, --seed, --first or --sanitize, found '$1'" ;;
            *) formats+=("$1") ;;
        esac
        shift
    done
    need_packages build test
    configure "$preset" -DPLIANT_BUILD_TESTS=ON -DPLIANT_TEST_ALL=ON
    compile "$preset" --target pliant_app mutate
    export ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1
    export UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
    "$root/build/$preset/tests/mutate/mutate" --program "$root/build/$preset/pliant" \
        --jobs "$(nproc)" --keep "$found" "${arguments[@]}" "${formats[@]}" ||
        fail "mutate: what is wrong stands above; inputs: $found"
}
