# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root comes from ./dev
#
# The pages that set Pliant beside its papers, each written by a program of its own: pictures and
# numbers together, or nothing where something fails.

readonly results_topics="chainmail, endoscope, haptics, pbd or springs"

results() { # TOPIC
    (($# == 1)) || fail "results: expected one topic ($results_topics), found $#"
    case $1 in
        chainmail | endoscope | haptics | pbd | springs) "results_$1" ;;
        *) fail "results: expected $results_topics, found '$1'" ;;
    esac
}

results_chainmail() {
    local scans=$root/../shared/data page=$root/docs/results/chainmail
    [[ -d $scans ]] || fail "results: the scans of the drag are not there: expected $scans"
    need_packages build bench
    configure release -DPLIANT_BUILD_BENCHMARKS=ON -DPLIANT_BUILD_TESTS=OFF
    compile release --target results_chainmail
    mkdir -p "$page"
    say "measuring and drawing; some minutes"
    "$root/build/release/results_chainmail" "$page" "$scans"
    say "done: docs/results/chainmail/README.md"
}

results_haptics() {
    local page=$root/docs/results/haptics
    need_packages build bench
    configure release -DPLIANT_BUILD_BENCHMARKS=ON -DPLIANT_BUILD_TESTS=OFF
    compile release --target results_haptics
    mkdir -p "$page"
    say "simulating and drawing; some minutes"
    "$root/build/release/results_haptics" "$page"
    say "done: docs/results/haptics/README.md"
}

results_pbd() {
    local page=$root/docs/results/pbd
    need_packages build bench
    configure release -DPLIANT_BUILD_BENCHMARKS=ON -DPLIANT_BUILD_TESTS=OFF
    compile release --target results_pbd
    mkdir -p "$page"
    say "measuring and drawing; a minute or two"
    "$root/build/release/results_pbd" "$page"
    say "done: docs/results/pbd/README.md"
}

results_springs() {
    local page=$root/docs/results/springs
    need_packages build bench
    configure release -DPLIANT_BUILD_BENCHMARKS=ON -DPLIANT_BUILD_TESTS=OFF
    compile release --target results_springs
    mkdir -p "$page"
    say "identifying, measuring and drawing; some minutes"
    "$root/build/release/results_springs" "$page" "$root/../shared/data"
    say "done: docs/results/springs/README.md"
}

results_endoscope() {
    local page=$root/docs/results/endoscope
    need_packages build
    need_browser
    build
    say "measuring and drawing in a browser; some minutes"
    (cd "$root/viewer" && PLIANT_SERVER=$root/build/release/pliant PLIANT_RESULTS=$page \
        npm run --silent measure endoscope)
    say "done: docs/results/endoscope/README.md"
}
