# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root and called_from come from ./dev
#
# The Python module: its wheel, which holds all libraries that it needs, and its tests in an
# environment of their own.

readonly most_wheel_mb=25

# Makes a virtual environment with the packages of a list, anew if the list has changed. Another
# shell that does so is waited for.
environment() { # NAME [FOLDER]
    local list=$root/python/requirements/$1.txt folder=${2:-$root/build/python-$1} lock
    mkdir -p "$(dirname "$folder")"
    exec {lock}>"$folder.lock"
    flock "$lock"
    cmp -s "$list" "$folder/requirements.txt" && return
    say "virtual environment ${folder#"$root/"}"
    rm -rf "$folder"
    python3 -m venv "$folder"
    "$folder/bin/pip" install -q --disable-pip-version-check -r "$list"
    cp "$list" "$folder/requirements.txt"
}

# With the compiler and the warnings of the build that ccache may have.
wheel() {
    need_packages build wheel
    build_viewer
    environment build
    local bin=$root/build/python-build/bin raw wheel
    rm -rf "$root/build/wheels" "$root/build/dist"
    (cd "$root" && CXX=g++ PATH=$bin:$PATH \
        "$bin/pip" wheel -q --disable-pip-version-check --no-deps --no-build-isolation \
        --config-settings cmake.define.PLIANT_WARNINGS_AS_ERRORS=ON -w build/wheels .)
    raw=("$root"/build/wheels/*.whl)
    PATH=$bin:$PATH "$bin/auditwheel" repair -w "$root/build/dist" "${raw[0]}" >/dev/null 2>&1
    wheel=("$root"/build/dist/*.whl)
    PATH=$bin:$PATH "$bin/auditwheel" show "${wheel[0]}" | sed -n '/is consistent/,$p'
    (($(stat -c %s "${wheel[0]}") <= most_wheel_mb << 20)) ||
        fail "wheel: expected at most $most_wheel_mb MB, found $(du -h "${wheel[0]}")"
    say "build/dist/${wheel[0]##*/}, $(($(stat -c %s "${wheel[0]}") >> 10)) KiB"
}

# The module of build/gcc, without a wheel: build/python-module.
install_module() {
    local module=$root/build/python-module
    rm -rf "$module"
    cmake --install "$root/build/gcc" --prefix "$module" --component python >/dev/null
    cp -r "$root"/python/pliant/. "$module/pliant/"
}

# Its tests but the long ones, and its types.
test_module() {
    environment test
    local python=$root/build/python-test/bin/python module=$root/build/python-module
    install_module
    local inputs=("$module" "$root/python/tests" "$root/python/examples" "$root/docs")
    export PYTHONPATH=$module MYPYPATH=$module PYTHONDONTWRITEBYTECODE=1
    unless_passed python "${inputs[@]}" -- env -C "$root/python/tests" \
        "$python" -m pytest -q -p no:cacheprovider --ignore=large --durations=8 -n "$(nproc)" \
        $(long_python_tests | sed "s#^#--deselect=python/tests/#") .
    unless_passed python-types "${inputs[@]}" -- env -C "$root/python/tests" \
        "$python" -m mypy --strict --cache-dir="$root/build/mypy" -p pliant
    unless_passed python-use-types "${inputs[@]}" -- env -C "$root/python/tests" \
        "$python" -m mypy --strict --cache-dir="$root/build/mypy" use_types.py
}

# Installs the wheel alone into an empty environment, and tests it beside the packages that it
# works with.
test_wheel() {
    wheel
    environment test
    local empty wheels=("$root"/build/dist/*.whl) bin=$root/build/python-test/bin
    empty=$(mktemp -d)
    # shellcheck disable=SC2064
    trap "rm -rf '$empty'" EXIT
    python3 -m venv "$empty"
    "$empty/bin/pip" install -q --disable-pip-version-check "${wheels[0]}"
    (cd "$empty" && env -i "$empty/bin/python" -c \
        'import pliant; print("empty environment: pliant", pliant.__version__)')
    "$bin/pip" install -q --disable-pip-version-check --force-reinstall --no-deps "${wheels[0]}"
    "$bin/pip" list --disable-pip-version-check 2>/dev/null | grep -iE 'pliant|numpy|itk|nibabel'
    (cd "$root/python/tests" &&
        "$bin/python" -m pytest -q -p no:cacheprovider --ignore=large -n "$(nproc)" .)
    # pliant's own code, and a user's.
    (cd "$root/python/tests" && "$bin/mypy" --strict --cache-dir="$empty/mypy" -p pliant &&
        "$bin/mypy" --strict --cache-dir="$empty/mypy" use_types.py)
}

# Beside the packages that people use it with, which take gigabytes: PLIANT_CACHE names a folder
# that keeps them for other checkouts.
large_environment() {
    environment large "${PLIANT_CACHE:-$root/build}/python-large"
}

test_beside_large_packages() {
    local bin=${PLIANT_CACHE:-$root/build}/python-large/bin wheels=("$root"/build/dist/*.whl)
    large_environment
    "$bin/pip" install -q --disable-pip-version-check --force-reinstall --no-deps "${wheels[0]}"
    # Without -q, which hides the versions of the packages.
    (cd "$root/python/tests/large" && "$bin/python" -m pytest -p no:cacheprovider .)
}

# Studies on Dask and MPI, in Zarr and object stores, in an environment of its own: the engines and
# a local server of S3's protocol take a third of a gigabyte.
test_studies() {
    need_packages study
    environment study "${PLIANT_CACHE:-$root/build}/python-study"
    local bin=${PLIANT_CACHE:-$root/build}/python-study/bin wheels=("$root"/build/dist/*.whl)
    "$bin/pip" install -q --disable-pip-version-check --force-reinstall --no-deps "${wheels[0]}"
    "$bin/pip" list --disable-pip-version-check 2>/dev/null |
        grep -iE '^(pliant|distributed|mpi4py|s3fs|zarr|moto)'
    (cd "$root/python/tests" && "$bin/python" -m pytest -q -p no:cacheprovider test_study*.py \
        large/test_study_engines.py)
}

# Runs the notebooks of docs/ and keeps their results in them. @pre test_beside_large_packages ran
notebooks() { # [NAME…]
    "${PLIANT_CACHE:-$root/build}/python-large/bin/python" "$root/python/notebooks.py" "$@"
}
