# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root comes from ./dev
#
# `./dev package`: Debian packages of this machine's system or of another release's, and their trial
# on a bare one. mmdebstrap makes systems of other releases; it needs no privileges.

package() { # [--for CODENAME] [--try]
    local codename='' trial=no
    while (($#)); do
        case $1 in
            --for)
                codename=${2:-}
                [[ $codename =~ ^[a-z]+$ ]] ||
                    fail "package: expected --for and a release, such as trixie, found '$codename'"
                shift
                ;;
            --try) trial=yes ;;
            *) fail "package: expected --for, --try or nothing, found '$1'" ;;
        esac
        shift
    done
    # The same bits for the same commit.
    SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git -C "$root" log -1 --format=%ct)}
    export SOURCE_DATE_EPOCH
    if [[ -n $codename ]]; then
        package_for "$codename"
    else
        package_here
    fi
    [[ $trial == no ]] || try_package "$codename"
}

package_here() {
    local release=$root/build/release
    need_packages build package
    build_viewer
    configure release -DPLIANT_BUILD_TESTS=OFF -DPLIANT_RESEARCH=OFF -DPLIANT_BUILD_BENCHMARKS=OFF
    compile release
    rm -rf "$release/descriptions" "$root/build/packages"
    python3 "$root/tools/package/describe.py" "$release/pliant" "$release/descriptions"
    # Folders that all may enter, whatever the caller's umask.
    (umask 022 && cd "$release" && cpack -B "$root/build/packages" >"$root/build/package.log") || {
        cat "$root/build/package.log" >&2
        fail "package: CPack could not make the packages"
    }
    rm -rf "$root/build/packages/_CPack_Packages"
    say "$(cd "$root/build" && du -h packages/*.deb)"
}

# In a system of that release, with its compiler and libraries; the page is bundled here.
package_for() { # CODENAME
    local sources=$root/build/sources-$1.tar packages=$root/build/packages-$1
    need_packages bare
    build_viewer
    (cd "$root" && {
        git ls-files -z
        [[ ! -d viewer/dist ]] || find viewer/dist -type f -print0
    } | tar -c --format=pax --null -T - -f "$sources")
    rm -rf "$packages"
    mkdir -p "$packages"
    export PLIANT_CCACHE=''
    if ((EUID == 0)) && command -v ccache >/dev/null; then
        PLIANT_CCACHE=$(ccache --get-config cache_dir)
        CCACHE_MAXSIZE=$(ccache --get-config max_size)
        export CCACHE_MAXSIZE
        mkdir -p "$PLIANT_CCACHE"
    fi
    # shellcheck disable=SC2016  # expanded by mmdebstrap's shell
    bare_system "$1" --customize-hook='mkdir "$1/pliant"' \
        --customize-hook="tar-in $sources /pliant" \
        --customize-hook="$root/tools/package/compile.sh" \
        --customize-hook="sync-out /pliant/build/packages $packages" ||
        fail "package: see above what failed in a system of $1"
    rm "$sources"
    say "$(cd "$root/build" && du -h "packages-$1"/*.deb)"
}

# In a system of the same release with nothing but apt: the program pushes and serves, a program is
# built with the library, and both are removed without a trace.
try_package() { # [CODENAME]
    local codename=${1:-$(. /etc/os-release && echo "$VERSION_CODENAME")}
    local packages=$root/build/packages${1:+-$1}
    local commands=$root/tools/package/try.sh example=$root/examples/consumer
    bare_system "$codename" --customize-hook="mkdir \"\$1/try\"" \
        --customize-hook="cp -r $packages/. $example $commands \"\$1/try\"" \
        --customize-hook='chroot "$1" sh /try/try.sh' ||
        fail "package: see above what a bare $codename could not do"
    say "package: works on a bare $codename"
}

# Makes a system with nothing but apt, runs hooks of mmdebstrap in it, and removes it. Its archive
# is PLIANT_MIRROR, or else that of this machine if it has the same release, or else the usual one
# of its distribution.
bare_system() { # CODENAME --customize-hook=…
    local codename=$1 sources=() options=()
    shift
    need_packages bare
    if [[ -n ${PLIANT_MIRROR:-} ]]; then
        sources=("$PLIANT_MIRROR")
    else
        mapfile -t sources < <(grep -lE "[ :]$codename( |$)" /etc/apt/sources.list \
            /etc/apt/sources.list.d/*.sources /etc/apt/sources.list.d/*.list 2>/dev/null |
            head -n 1)
    fi
    if grep -q ",$codename," /usr/share/distro-info/ubuntu.csv; then
        options=(--components=main,universe)
        [[ -e /usr/share/keyrings/$ubuntu_keys ]] || options+=(--keyring="$(fetch_ubuntu_keys)")
    fi
    mmdebstrap --variant=apt --mode=auto --quiet --dpkgopt=force-unsafe-io "${options[@]}" "$@" \
        "$codename" /dev/null "${sources[@]}"
}

readonly ubuntu_keys=ubuntu-archive-keyring.gpg

# Prints the file of Ubuntu's keys. Debian 12 has no package of them; Debian 13 has.
fetch_ubuntu_keys() {
    local file=$root/build/$ubuntu_keys
    [[ -s $file ]] ||
        mmdebstrap --variant=extract --include=ubuntu-keyring --quiet trixie - |
        tar -xO "./usr/share/keyrings/$ubuntu_keys" >"$file"
    [[ -s $file ]] || fail "package: expected the keys of Ubuntu's archive in Debian 13, found none"
    echo "$file"
}
