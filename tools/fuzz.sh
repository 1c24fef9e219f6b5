# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root and called_from come from ./dev
#
# `./dev fuzz`: libFuzzer's programs, one after the other. build/fuzz-corpus keeps their inputs for
# the next time. build/fuzz-found has the failing inputs, to be run again by the same program; they
# belong into tests/fuzz/corpus once the fault is repaired.

fuzz() { # [TARGET…] [--seconds N]
    local seconds=600 targets=() target
    while (($#)); do
        case $1 in
            --seconds)
                [[ ${2:-} =~ ^[0-9]+$ ]] || fail "fuzz: --seconds: expected a number"
                seconds=$2
                shift
                ;;
            *)
                [[ -f $root/tests/fuzz/fuzz_$1.cpp ]] ||
                    fail "fuzz: expected a target of tests/fuzz, found '$1'"
                targets+=("$1")
                ;;
        esac
        shift
    done
    ((${#targets[@]})) ||
        mapfile -t targets < <(cd "$root/tests/fuzz/corpus" && printf '%s\n' *)
    need_packages build test fuzz
    configure fuzz -DPLIANT_BUILD_TESTS=ON
    compile fuzz --target "${targets[@]/#/fuzz_}"
    for target in "${targets[@]}"; do
        step "fuzz: $target" fuzz_one "$target" "$seconds"
    done
    summary
}

# The words of the format that a target reads; several share one.
dictionary_of() { # TARGET
    case $1 in
        labels | organs | vessel | fit | state) echo settings ;;
        markups | keyframes | messages | network | session) echo json ;;
        *) echo "$1" ;;
    esac
}

fuzz_one() { # TARGET SECONDS
    local target=$1 seconds=$2
    local learnt=$root/build/fuzz-corpus/$target found=$root/build/fuzz-found/$target
    mkdir -p "$learnt" "$found"
    ulimit -c 0
    export ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1
    export UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
    local words=() dictionary=$root/tests/fuzz/dictionaries/$(dictionary_of "$target").dict
    [[ ! -f $dictionary ]] || words=(-dict="$dictionary")
    "$root/build/fuzz/tests/fuzz/fuzz_$target" -max_total_time="$seconds" -timeout=60 \
        "${words[@]}" -rss_limit_mb=2000 -max_len=1048576 -use_value_profile=1 \
        -print_final_stats=1 -verbosity=1 \
        -artifact_prefix="$found/" "$learnt" "$root/tests/fuzz/corpus/$target"
}
