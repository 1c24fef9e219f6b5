# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root comes from ./dev
#
# `./dev package`: Debian packages of this machine's system, in build/packages, and their trial on a
# bare one.

package() { # [--try]
    local release=$root/build/release
    [[ ${1:-} =~ ^(--try)?$ ]] || fail "package: expected --try or nothing, found '$1'"
    need_packages build package
    build_viewer
    configure release -DPLIANT_BUILD_TESTS=OFF -DPLIANT_RESEARCH=OFF -DPLIANT_BUILD_BENCHMARKS=OFF
    compile release
    rm -rf "$release/descriptions" "$root/build/packages"
    python3 "$root/tools/package/describe.py" "$release/pliant" "$release/descriptions"
    # The same bits for the same commit.
    SOURCE_DATE_EPOCH=$(git -C "$root" log -1 --format=%ct)
    export SOURCE_DATE_EPOCH
    (cd "$release" && cpack -B "$root/build/packages" >"$root/build/package.log") || {
        cat "$root/build/package.log" >&2
        fail "package: CPack could not make the packages"
    }
    rm -rf "$root/build/packages/_CPack_Packages"
    say "$(cd "$root/build" && du -h packages/*.deb)"
    [[ -z ${1:-} ]] || try_package
}

# In a system of the same release with nothing but apt: the program pushes and serves, a program is
# built with the library, and both are removed without a trace.
try_package() {
    local codename sources
    codename=$(. /etc/os-release && echo "$VERSION_CODENAME")
    need_packages package-try
    # The main archive of this machine, wherever it is copied from.
    mapfile -t sources < <(grep -lE "[ :]$codename( |$)" /etc/apt/sources.list \
        /etc/apt/sources.list.d/*.sources /etc/apt/sources.list.d/*.list 2>/dev/null | head -n 1)
    local commands=$root/tools/package/try.sh example=$root/examples/consumer
    mmdebstrap --variant=apt --mode=auto --quiet \
        --customize-hook="mkdir \"\$1/try\"" \
        --customize-hook="cp -r $root/build/packages/. $example $commands \"\$1/try\"" \
        --customize-hook='chroot "$1" sh /try/try.sh' \
        "$codename" /dev/null "${sources[@]}" ||
        fail "package: see above what a bare $codename could not do"
    say "package: works on a bare $codename"
}
