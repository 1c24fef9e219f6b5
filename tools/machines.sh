# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root comes from ./dev
#
# `./dev machines`: the library, the program and the core rooms' tests for other processors, by
# Debian's cross compilers, and run by qemu-user. s390x is big-endian.

readonly all_machines=(s390x aarch64 riscv64)
# Rooms whose tests run on other machines.
readonly machine_tests=(base volume mesh formats field material propagate relax chainmail elastic
    resample springs pbd fem tissue protocol session machines)
# Tests that ask for more than qemu-user has, with the reason.
readonly machine_excluded=tests/machines/left_out.txt

debian_name() { # MACHINE
    case $1 in
        aarch64) echo arm64 ;;
        *) echo "$1" ;;
    esac
}

# Debian has riscv64 since 13.
debian_suite() { # MACHINE
    local suite
    suite=$(. /etc/os-release && echo "$VERSION_CODENAME")
    [[ $1 != riscv64 || $suite != bookworm ]] || suite=trixie
    echo "$suite"
}

# The libraries of a machine's Debian: extracted, nothing of it runs.
machine_root() { # MACHINE
    local machine=$1 folder=$root/build/machines/$1-root suite packages link target
    [[ ! -f $folder/complete ]] || return 0
    suite=$(debian_suite "$machine")
    packages=$(packages_of build | tr ' ' '\n' | grep -- '-dev$' | paste -sd,)
    rm -rf "$folder"
    mmdebstrap --variant=extract --mode=auto --quiet --architectures="$(debian_name "$machine")" \
        --include="$packages,libgtest-dev,libc6-dev,libstdc++6" "$suite" "$folder" \
        ${PLIANT_MIRROR:+"$PLIANT_MIRROR"} ||
        fail "machines: could not extract the packages of Debian's $machine"
    [[ -e $folder/lib ]] || ln -s usr/lib "$folder/lib"
    # Absolute links would lead to this machine's files.
    find "$folder" -type l -lname '/*' | while read -r link; do
        target=$folder$(readlink "$link")
        ln -sfn "$(realpath -m --no-symlinks --relative-to="$(dirname "$link")" "$target")" "$link"
    done
    mkdir "$folder/link"
    if [[ $suite != "$(debian_suite x86_64)" ]]; then
        ln -s "../usr/lib/$machine-linux-gnu/libstdc++.so.6" "$folder/link/libstdc++.so"
        ln -s "$(command -v ld.lld-19)" "$folder/link/ld.lld"
    fi
    touch "$folder/complete"
}

emulated() { # MACHINE COMMAND…
    "qemu-$1-static" -L "$root/build/machines/$1-root" "${@:2}"
}

# -O1: half the time to compile, and the same bits.
build_for() { # MACHINE
    local machine=$1 build=$root/build/machines/$1 log=$root/build/machines/$1-configure.log
    cmake -S "$root" -B "$build" -G Ninja \
        -DCMAKE_TOOLCHAIN_FILE="$root/cmake/other_machine.cmake" -DPLIANT_MACHINE="$machine" \
        -DPLIANT_MACHINE_ROOT="$root/build/machines/$machine-root" -DCMAKE_BUILD_TYPE=Machine \
        -DCMAKE_CXX_FLAGS_MACHINE=-O1 -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=0 \
        -DPLIANT_BUILD_TESTS=ON -DPLIANT_BUILD_VIEWER=OFF -DPLIANT_INSTALL=OFF >"$log" 2>&1 || {
        cat "$log" >&2
        fail "machines: CMake could not configure build/machines/$machine"
    }
    cmake --build "$build" --target pliant_app "${machine_tests[@]/#/test_}"
    emulate_decoder "$machine"
}

# The library starts this program; the kernel can't, without qemu.
emulate_decoder() { # MACHINE
    local program=$root/build/machines/$1/pliant-decode-pixels
    [[ $(head -c 4 "$program") == $'\x7fELF' ]] || return 0
    mv "$program" "$program.$1"
    printf '#!/bin/sh\nexec qemu-%s-static -L %q %q "$@"\n' "$1" \
        "$root/build/machines/$1-root" "$program.$1" >"$program"
    chmod 755 "$program"
}

left_out_on() { # MACHINE; as a filter of GoogleTest's
    {
        long_tests
        sed -nE "s/^([^# ]+) +(all|$1) .*/\1/p" "$root/$machine_excluded"
    } | paste -sd:
}

test_on() { # MACHINE
    local machine=$1 build=$root/build/machines/$1 name failed=()
    export PLIANT_MACHINE_FILES=$root/build/machines/files
    for name in "${machine_tests[@]}"; do
        GTEST_FILTER="-$(left_out_on "$machine")" GTEST_BRIEF=1 \
            emulated "$machine" "$build/tests/test_$name" >"$build/$name.log" 2>&1 ||
            failed+=("$name")
        echo "$name: $(grep -E '^\[  (PASSED|FAILED)|tests? ran|SKIPPED' "$build/$name.log" |
            paste -sd' ')"
    done
    grep -h '^all sequences' "$build/machines.log" || true
    ((${#failed[@]} == 0)) || fail "machines: failed on $machine: ${failed[*]}"
}

# This machine writes its files, and reads those of the others.
files_here() {
    compile gcc --target test_machines
    PLIANT_MACHINE_FILES=$root/build/machines/files "$root/build/gcc/tests/test_machines"
}

machines() { # [MACHINE…]
    local machine wanted=("$@")
    ((${#wanted[@]})) || wanted=("${all_machines[@]}")
    for machine in "${wanted[@]}"; do
        [[ " ${all_machines[*]} " == *" $machine "* ]] ||
            fail "machines: expected some of ${all_machines[*]}, found '$machine'"
    done
    need_packages build test
    configure gcc -DPLIANT_BUILD_TESTS=ON -DPLIANT_TEST_ALL=ON
    rm -rf "$root/build/machines/files"
    step "this machine: files, sequences" files_here
    for machine in "${wanted[@]}"; do
        need_packages "machine-$machine"
        step "$machine: Debian's libraries" machine_root "$machine"
        step "$machine: build" build_for "$machine"
        step "$machine: tests" test_on "$machine"
    done
    step "this machine: the others' files" files_here
    summary
}
