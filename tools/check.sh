# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root and called_from come from ./dev
#
# The steps of `./dev test` and `./dev lint`, each named and timed.

readonly clang_format=clang-format-14  # other versions set some lines differently
step_lines=()
missed=()  # steps of --all that failed

# Runs a command, and notes the time that it took. Sets status.
timed() { # NAME REMARK COMMAND…
    local name=$1 remark=$2 start=$SECONDS
    shift 2
    say "$name"
    # In a subshell with its own -e: inside of a condition the shell would ignore failures.
    set +e
    (
        set -e
        "$@"
    )
    status=$?
    set -e
    ((status == 0)) || remark+=" FAILED"
    step_lines+=("$(printf '%-52s %5d s%s' "$name" $((SECONDS - start)) "$remark")")
}

step() { # NAME COMMAND…
    local status
    timed "$1" '' "${@:2}"
    ((status == 0)) || {
        summary
        fail "failed: $1"
    }
}

# A step that only `--all` has: a failure doesn't end the run, the end names all of them.
rest() { # NAME COMMAND…
    local status
    timed "$1" '  (--all)' "${@:2}"
    ((status == 0)) || missed+=("$1")
}

summary() {
    say "summary"
    printf '%s\n' "${step_lines[@]}"
}

lint() {
    cd "$root"
    tools/check_layers --self-test
    tools/check_layers
    tools/check_classes --self-test
    tools/check_classes
    tools/check_bibliography --self-test
    tools/check_bibliography
    tools/check_links --self-test
    tools/check_links
    tools/check_files --self-test
    tools/check_files
    tools/check_evidence --self-test
    tools/check_evidence
    tools/api_list --self-test
    tools/package/sbom.py --self-test
    tools/mutate_code --self-test
    tools/mutate_code --check
    tools/faults --self-test
    if find changes -name '*.md' -printf '%f\n' |
        grep -vE '^\+[a-z0-9-]+\.(added|changed|deprecated|removed|fixed|security)\.md$'; then
        fail "changes/: expected +NAME.KIND.md (CONTRIBUTING.md), found the above"
    fi
    local formatter=$clang_format
    command -v "$formatter" >/dev/null || formatter=clang-format
    find include src apps tests examples benchmarks python research \
        -regex '.*\.\(h\|cpp\|inc\)' -print0 |
        xargs -0 "$formatter" --dry-run -Werror
    echo "format: as .clang-format says"
    # shellcheck disable=SC2016  # the quotes around code in Markdown
    diff <(sed -n '/^```cpp$/,/^```$/{/^```/d;p}' README.md) \
        <(sed -n '/^#include <pliant/,$p' examples/consumer/push.cpp) ||
        fail "README.md: expected its C++ to be that of examples/consumer/push.cpp"
    echo "README.md: shows the example that is compiled"
}

# Tests that take half of the time and rarely say anything that others don't: random sequences in
# full, each failing allocation, damaged files by the thousand. The short run leaves them out,
# `./dev test --all` runs them afterwards.
long_tests() { # as a filter of GoogleTest's
    sed -n 's/^\([^# ]\+\).*/\1/p' "$root/tests/long_tests.txt" | paste -sd:
}

long_python_tests() {
    sed -n 's/^# python: //p' "$root/tests/long_tests.txt"
}

unless_passed() { # NAME [INPUT…] -- COMMAND…
    PLIANT_PASSED=$root/build/passed "$root/tools/unless_passed" "$@"
}

# With the Python module: one configuration, one compilation.
compile_with_gcc() { # [cmake --build arguments…]
    local python=$root/build/python-build/bin/python
    environment build
    configure gcc -DPLIANT_BUILD_TESTS=ON -DPLIANT_BUILD_PYTHON=ON -DPython_EXECUTABLE="$python" \
        -Dnanobind_DIR="$("$python" -m nanobind --cmake_dir)"
    compile gcc "$@"
}

tests_run_by=()  # a command that runs the given one

run_ctest() { # PRESET [ctest arguments…]
    local preset=$1
    shift
    "${tests_run_by[@]}" ctest --test-dir "$root/build/$preset" --output-on-failure \
        --no-tests=error -j "$(nproc)" "$@" | tee "$root/build/$preset-ctest.log"
}

test_short() {
    GTEST_FILTER="-$(long_tests)" run_ctest gcc --label-exclude 'long|research'
}

# The tests that test_short leaves out.
test_long() {
    export PLIANT_EACH_TEST=1
    compile gcc --target long_tests
    run_ctest gcc --label-regex long
    GTEST_FILTER="$(long_tests)" run_ctest gcc --label-exclude 'long|research'
}

# pliant::research and the comparisons with papers.
test_research() {
    configure gcc -DPLIANT_RESEARCH=ON
    compile gcc
    PLIANT_EACH_TEST=1 run_ctest gcc --label-regex research
}

compile_and_test() { # PRESET [CMake arguments…]
    configure "$@" -DPLIANT_BUILD_TESTS=ON
    compile "$1" --target all long_tests
    PLIANT_EACH_TEST=1 run_ctest "$1"
}

# The rooms with vector code, as shared libraries.
compile_and_test_with_clang() {
    GTEST_FILTER="-$(long_tests)" \
        compile_and_test clang -DPLIANT_TEST_ALL=OFF -DBUILD_SHARED_LIBS=ON
}

# Builds an example against an installed package, as a user would.
build_example() { # EXAMPLE PREFIX [CMake arguments…]
    local example=$1 prefix=$2
    shift 2
    cmake --no-warn-unused-cli -S "$root/examples/$example" -B "$prefix/build/$example" -G Ninja \
        -DCMAKE_CXX_COMPILER=g++ -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror" \
        -DCMAKE_PREFIX_PATH="$prefix" "$@" >"$prefix/$example.log" 2>&1 || {
        cat "$prefix/$example.log" >&2
        return 1
    }
    cmake --build "$prefix/build/$example"
}

# Libraries that the component `models` must not need, by CMake's names and by those of files. To
# build it, the headers of Eigen and toml++ are needed, to use it not.
readonly not_for_models=(Boost CLI11 GDCM OpenSSL PNG ZLIB nlohmann_json pugixml)
readonly no_files_for_models='boost|lib(ssl|crypto)|gdcm|png|/libz\.|pugi|toml'\
'|pliant_(io|view|scenes|serve)'

# CMake's arguments that hide packages.
without() { # PACKAGE…
    printf -- '-DCMAKE_DISABLE_FIND_PACKAGE_%s=ON\n' "$@"
}

# Voxels in memory and ChainMail, with one component of the package.
use_models_alone() { # PREFIX
    local build=$1/build/voxels_in_memory used hidden
    mapfile -t hidden < <(without "${not_for_models[@]}" Eigen3 tomlplusplus)
    build_example voxels_in_memory "$1" "${hidden[@]}"
    "$build/voxels_in_memory" --check
    used=$(ninja -C "$build" -t commands voxels_in_memory && ldd "$build/voxels_in_memory")
    ! grep -E "$no_files_for_models" <<<"$used" ||
        fail "models: expected to link oneTBB, Highway and LZ4 alone"
}

use_example() { # PREFIX EXAMPLE [ARGUMENT…]
    build_example "$2" "$1/static"
    "$1/static/build/$2/$2" "${@:3}" --check
}

# Builds and runs the program of docs/hello.md, from the files that a reader makes of it.
use_hello() { # PREFIX
    local folder=$1/build/hello page=$root/docs/hello.md
    mkdir -p "$folder"
    # shellcheck disable=SC2016  # the quotes around code in Markdown
    {
        sed -n '/^```cpp$/,/^```$/{/^```/d;p}' "$page" >"$folder/hello.cpp"
        sed -n '/^```cmake$/,/^```$/{/^```/d;p}' "$page" >"$folder/CMakeLists.txt"
    }
    cmake -S "$folder" -B "$folder/build" -G Ninja -DCMAKE_CXX_COMPILER=g++ \
        -DCMAKE_PREFIX_PATH="$1" >/dev/null
    cmake --build "$folder/build"
    "$1/bin/pliant" phantom airway --out "$folder/airway.nrrd" >/dev/null
    (cd "$folder" && build/hello airway.nrrd) | grep '^100 % of the push, [1-9]' ||
        fail "docs/hello.md: expected its program to push the airway"
}

# Runs commands, as many at a time as there are processors; each is a line of words.
at_once() { # COMMAND…
    local command running=0
    for command in "$@"; do
        if ((running == $(nproc))); then
            wait -n
            running=$((running - 1))
        fi
        # shellcheck disable=SC2086  # words
        $command &
        running=$((running + 1))
    done
    while ((running-- > 0)); do wait -n; done
}

# Installs to a temporary prefix and uses the package.
consumer() {
    local prefix hidden
    prefix=$(mktemp -d)
    # shellcheck disable=SC2064
    trap "rm -rf '$prefix'" EXIT
    cmake --install "$root/build/gcc" --prefix "$prefix/static" >/dev/null
    at_once "use_example $prefix consumer $prefix" \
        "use_hello $prefix/static" \
        "use_example $prefix "{own_tissue,own_law,own_tool,own_mapper,soft_body,host_loop}
    "$prefix/static/bin/pliant" --version
    use_models_alone "$prefix/static"
    cmake -S "$root/tests/package" -B "$prefix/package" -G Ninja -DCMAKE_CXX_COMPILER=g++ \
        -DCMAKE_PREFIX_PATH="$prefix/static" -DCMAKE_DISABLE_FIND_PACKAGE_PNG=ON >/dev/null
    echo "package: answers for each of its components where libpng is missing"
    mapfile -t hidden < <(without "${not_for_models[@]}")
    cmake --no-warn-unused-cli -S "$root" -B "$prefix/models" -G Ninja -DCMAKE_CXX_COMPILER=g++ \
        -DPLIANT_COMPONENTS=models "${hidden[@]}" >/dev/null
    echo "package: models alone is configured without ${not_for_models[*]}"
}

# Clang's shared libraries, as a user links them.
consumer_of_shared() {
    local prefix
    prefix=$(mktemp -d)
    # shellcheck disable=SC2064
    trap "rm -rf '$prefix'" EXIT
    cmake --install "$root/build/clang" --prefix "$prefix/shared" >/dev/null
    "$prefix/shared/bin/pliant" --version
    use_models_alone "$prefix/shared"
}

# GCC's thread sanitizer needs an address space that is laid out the same each time.
fixed_addresses() {
    if setarch "$(uname -m)" -R true 2>/dev/null; then
        setarch "$(uname -m)" -R "$@"
    else
        "$@"
    fi
}

sanitize_addresses() {
    export ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1
    export UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
    compile_and_test asan
}

sanitize_threads() {
    export TSAN_OPTIONS=suppressions=$root/tools/tsan.supp:halt_on_error=1:second_deadlock_stack=1
    tests_run_by=(fixed_addresses)
    compile_and_test tsan
}

# Compiles each source alone, without the includes of its room's other sources.
compile_alone() {
    configure alone
    compile alone
}

# Each file says its licence, by itself or in REUSE.toml.
licences() {
    environment licences
    "$root/build/python-licences/bin/reuse" --root "$root" lint --quiet ||
        fail "licences: ./build/python-licences/bin/reuse lint says what is missing"
}

run_tests() { # [--all] [--sanitize]
    local all=no sanitize=no argument
    for argument in "$@"; do
        case $argument in
            --all) all=yes ;;
            --sanitize) sanitize=yes ;;
            *) fail "test: expected --all, --sanitize or nothing, found '$argument'" ;;
        esac
    done
    need_packages build test lint wheel
    if [[ $all == yes ]]; then
        export PLIANT_EACH_TEST=1
        mkdir -p "$root/build"
        (large_environment) >"$root/build/python-large.log" 2>&1 &  # the network's time, not ours
    fi
    step "lint: layers, bibliography, files, format" lint
    if [[ ${PLIANT_BUILD_VIEWER:-ON} != OFF ]]; then
        step "page: bundle, types" check_viewer
    fi
    step "gcc: build without warnings" compile_with_gcc
    step "gcc: tests" test_short
    step "python: module, types" test_module
    step "slicer: its client beside the program" test_slicer_client
    step "examples: install, find_package, build, run" consumer
    if [[ ${PLIANT_BUILD_VIEWER:-ON} != OFF ]]; then
        step "page: driven in a browser" test_viewer_short "$root/build/gcc/pliant"
    fi
    [[ $all == no ]] || run_the_rest
    if [[ $sanitize == yes ]]; then
        step "address and undefined-behaviour sanitizers" sanitize_addresses
        step "thread sanitizer" sanitize_threads
    fi
    summary
    [[ $all == no ]] || say_what_was_missed
    closing_lines
    ((${#missed[@]} == 0)) || fail "failed: ${missed[*]}"
}

# Steps that the short run leaves out. A failure doesn't end the run; its end names all of them.
run_the_rest() {
    rest "licences: REUSE" licences
    rest "docs: site, links" docs
    rest "gcc: long tests" test_long
    rest "research: build, tests" test_research
    rest "clang: build without warnings, tests" compile_and_test_with_clang
    rest "clang: shared libraries, used" consumer_of_shared
    rest "gcc: each source alone" compile_alone
    rest "python: wheel, empty environment, tests" test_wheel
    rest "python: beside large packages, notebooks" test_beside_large_packages
    rest "python: studies on engines and stores" test_studies
    rest "slicer: the extension beside VTK" test_slicer
    if [[ ${PLIANT_BUILD_VIEWER:-ON} != OFF ]]; then
        rest "page: all in a browser" test_viewer "$root/build/gcc/pliant"
    fi
}

say_what_was_missed() {
    if ((${#missed[@]})); then
        say "the short run would have missed: ${missed[*]}"
    else
        say "the short run would have missed nothing"
    fi
}

# The last lines of each ctest run, the ordinary build's at the end.
closing_lines() {
    local preset presets=(gcc)
    [[ $all == no ]] || presets=(clang gcc)
    [[ $sanitize == no ]] || presets=(tsan asan "${presets[@]}")
    for preset in "${presets[@]}"; do
        sed -n "s/^[0-9]*% tests passed.*/$preset: &/p" "$root/build/$preset-ctest.log"
    done | sed '$ s/^gcc: //'
}
