# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root comes from ./dev
#
# The page of `pliant serve`: TypeScript in viewer/, bundled into viewer/dist, which CMake puts into
# the program. Packages are those that package-lock.json pins, from npm.

# Node 18 or newer and npm. Not always Debian's: a Node from elsewhere brings its own npm, and the
# packages would be in each other's way.
need_node() {
    local major
    if command -v node >/dev/null && command -v npm >/dev/null; then
        major=$(node --version | sed 's/^v\([0-9]*\).*/\1/')
        ((major >= 18)) || fail "Node $(node --version) is too old; expected 18 or newer"
        return
    fi
    need_packages viewer
}

install_node_modules() {
    local stamp=$root/viewer/node_modules/.package-lock.json
    [[ ! $stamp -nt $root/viewer/package-lock.json ]] || return 0
    say "fetching the packages of the page, as viewer/package-lock.json pins them"
    (cd "$root/viewer" && npm ci --loglevel=error) ||
        fail "npm could not fetch the page's packages; without the page: PLIANT_BUILD_VIEWER=OFF"
}

# Bundles the page where a source is newer than the last bundle. A bundle that is up to date needs
# neither Node nor npm.
build_viewer() {
    [[ ${PLIANT_BUILD_VIEWER:-ON} != OFF ]] || return 0
    local bundle=$root/viewer/dist/licenses.txt  # written last
    if [[ -f $bundle && -z $(find "$root/viewer/src" "$root/viewer/build.mjs" \
        "$root/viewer/package-lock.json" -newer "$bundle" -print -quit) ]]; then
        return 0
    fi
    need_node
    install_node_modules
    say "bundling the page"
    (cd "$root/viewer" && npm run --silent build)
}

# Bundle and types.
check_viewer() {
    need_node
    install_node_modules
    build_viewer
    (cd "$root/viewer" && npm run --silent check)
    echo "viewer: types hold"
}

# A headless browser drives the page: all tests with the program's own server, and as many with the
# mock as show that it is still like it.
test_viewer() { # PROGRAM
    need_browser
    (cd "$root/viewer" && PLIANT_SERVER=$1 npm test --silent &&
        npm test --silent -- tissue instruments marks)
}

# Tests without a browser, and those of the page's main job with the program's own server.
test_viewer_short() { # PROGRAM
    need_browser
    unless_passed page "$1" "$root/viewer/src" "$root/viewer/test" -- \
        env -C "$root/viewer" PLIANT_SERVER="$1" npm test --silent -- --short
}

# Ubuntu has no package of Chromium: PLIANT_CHROMIUM names a browser from elsewhere.
need_browser() {
    local browser
    for browser in "${PLIANT_CHROMIUM:-}" /usr/bin/chromium-headless-shell /usr/bin/chromium; do
        [[ ! -x $browser ]] || return 0
    done
    need_packages browser
}
