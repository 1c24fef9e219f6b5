# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root comes from ./dev
#
# The pages that set Pliant beside its papers, each written by a program of its own: pictures and
# numbers together, or nothing where something fails.

readonly results_topics="chainmail, colours, endoscope, haptics, pbd, pushed, springs or worth"

results() { # TOPIC
    (($# == 1)) || fail "results: expected one topic ($results_topics), found $#"
    case $1 in
        chainmail | colours | endoscope | haptics | pbd | pushed | springs | worth) "results_$1" ;;
        *) fail "results: expected $results_topics, found '$1'" ;;
    esac
}

results_chainmail() {
    local scans=$root/../shared/data
    [[ -d $scans ]] || fail "results: the scans of the drag are not there: expected $scans"
    write_results chainmail "$scans"
}

results_colours() {
    local scans=$root/../shared/data
    [[ -d $scans ]] || fail "results: the scans of the lumina are not there: expected $scans"
    need_packages build
    configure release -DPLIANT_RESEARCH=ON -DPLIANT_BUILD_TESTS=OFF
    compile release --target results_colours
    "$root/build/release/results_colours" "$root/docs/results/endoscope" "$scans"
    say "done: docs/results/endoscope/colours.md"
}

results_haptics() {
    write_results haptics
}

results_pbd() {
    local scans=$root/../shared/data
    [[ -d $scans ]] || fail "results: the scans of the vessels are not there: expected $scans"
    write_results pbd "$root/scenes"
}

# Runs the commands of a page that shows their pictures.
results_pushed() {
    local page=$root/docs/results/endoscope scan=$root/../shared/data/thorax_ct_256.nrrd folder
    [[ -f $scan ]] || fail "results: the scan of the chest is not there: expected $scan"
    build
    folder=$(mktemp -d)
    ln -s "$(readlink -f -- "$scan")" "$folder"
    awk '/^```(sh|bash)$/ { inside = 1; next } /^```$/ { inside = 0 } inside' "$page/pushed.md" \
        >"$folder/commands"
    say "pushing and drawing"
    (cd "$folder" && PATH=$root/build/release:$PATH sh -eu commands)
    mv "$folder"/pushed_*_*.png "$page"
    rm -r "$folder"
    say "done: docs/results/endoscope/pushed.md"
}

results_springs() {
    write_results springs "$root/../shared/data"
}

results_worth() {
    local scans=$root/../shared/data
    [[ -d $scans ]] || fail "results: the scans are not there: expected $scans"
    write_results worth "$scans"
}

write_results() { # TOPIC [the program's further arguments…]
    local topic=$1 page=$root/docs/results/$1
    shift
    need_packages build
    configure release -DPLIANT_RESEARCH=ON -DPLIANT_BUILD_TESTS=OFF
    compile release --target "results_$topic"
    mkdir -p "$page"
    say "measuring and drawing; some minutes"
    "$root/build/release/results_$topic" "$page" "$@"
    say "done: docs/results/$topic/README.md"
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

# Measures the figures of docs/credibility with the programs of `./dev test`.
evidence() { # [RUN…]
    need_packages build test
    configure gcc -DPLIANT_BUILD_TESTS=ON -DPLIANT_TEST_ALL=ON
    compile gcc
    "$root/tools/check_evidence" --measure "$@"
    say "done: docs/credibility"
}
