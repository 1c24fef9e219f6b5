# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root and called_from come from ./dev
#
# The system packages that each task needs, by their names in Debian 12 and Ubuntu 24.04.
# THIRD_PARTY.md has the purpose of each library.

packages_of() {
    case $1 in
        build)
            echo g++ cmake ninja-build ccache libgdcm-dev libtbb-dev libcli11-dev \
                libtomlplusplus-dev nlohmann-json3-dev libhwy-dev libpng-dev \
                zlib1g-dev liblz4-dev libboost-dev libssl-dev libeigen3-dev libpugixml-dev
            ;;
        test) echo clang libgtest-dev universal-ctags abigail-tools ;;
        wheel) echo python3-dev python3-venv ;;
        study) echo openmpi-bin ;;
        package) echo dpkg-dev file python3 ;;
        package-try) echo mmdebstrap ;;
        lint) echo clang-format-14 python3 ;;
        fuzz) echo libclang-rt-dev ;;
        bench) echo libbenchmark-dev libembree-dev time ;;
        # Node from elsewhere brings its npm, and Debian's conflicts with it.
        viewer) command -v node >/dev/null && command -v npm >/dev/null || echo nodejs npm ;;
        browser) echo chromium-headless-shell ;;
    esac
}

# Prints the packages that are not installed.
missing_of() {
    local package
    for package in "$@"; do
        [[ $(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) == installed ]] ||
            echo "$package"
    done
}

need_packages() { # GROUP…
    local group wanted=() missing
    for group in "$@"; do
        # shellcheck disable=SC2207  # package names hold no spaces
        wanted+=($(packages_of "$group"))
    done
    if ! command -v dpkg-query >/dev/null; then
        say "this is no Debian or Ubuntu: going on with what is there. Needed are ${wanted[*]}"
        return
    fi
    mapfile -t missing < <(missing_of "${wanted[@]}")
    ((${#missing[@]})) || return 0

    local apt=(apt-get -o DPkg::Lock::Timeout=300)
    local by_hand="apt-get install --no-install-recommends ${missing[*]}"
    [[ -z ${PLIANT_NO_INSTALL:-} ]] || fail "packages are missing; install them: $by_hand"
    if ((EUID != 0)); then
        command -v sudo >/dev/null ||
            fail "packages are missing, and there is neither root nor sudo; as root: $by_hand"
        [[ -t 0 ]] || sudo -n true 2>/dev/null ||
            fail "packages are missing, and sudo can't ask for a password here; as root: $by_hand"
        apt=(sudo "${apt[@]}")
    fi
    say "will be installed with apt, and what they depend on: ${missing[*]}"
    "${apt[@]}" update -qq ||
        echo "dev: apt-get update had trouble; trying with the package lists that are there" >&2
    install_with_apt "${apt[@]}" ||
        fail "apt could not install the packages (see above); try yourself: $by_hand"
}

install_with_apt() { # the apt command; uses the list "missing" of its caller
    local command=("$@")
    [[ ${command[0]} == sudo ]] && command=(sudo env DEBIAN_FRONTEND=noninteractive "${@:2}")
    DEBIAN_FRONTEND=noninteractive "${command[@]}" install -y -q --no-install-recommends \
        "${missing[@]}"
}
