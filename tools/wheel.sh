# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154  # root and called_from come from ./dev
#
# The Python module: its wheel, which holds all libraries that it needs, and its tests in an
# environment of their own.

readonly most_wheel_mb=25

# Makes a virtual environment with the packages of a list, anew if the list has changed. Another
# shell that does so is waited for.
environment() { # NAME [FOLDER [PYTHON]]
    local list=$root/python/requirements/$1.txt folder=${2:-$root/build/python-$1} lock
    mkdir -p "$(dirname "$folder")"
    exec {lock}>"$folder.lock"
    flock "$lock"
    cmp -s "$list" "$folder/requirements.txt" && return
    say "virtual environment ${folder#"$root/"}"
    rm -rf "$folder"
    "${3:-python3}" -m venv "$folder"
    "$folder/bin/pip" install -q --disable-pip-version-check -r "$list"
    cp "$list" "$folder/requirements.txt"
}

# One wheel for each interpreter.
wheel() { # [PYTHON…]
    local python
    need_packages build wheel
    build_viewer
    rm -rf "$root/build/wheels" "$root/build/dist"
    for python in "${@:-python3}"; do
        wheel_of "$python"
    done
}

# With the compiler and the warnings of the build that ccache may have.
wheel_of() { # PYTHON
    local folder=$root/build/python-build bin wheel
    "$1" -c '' 2>/dev/null || fail "wheel: expected an interpreter of Python, found '$1'"
    [[ $1 == python3 ]] || folder+=-$(basename "$1")
    environment build "$folder" "$1"
    bin=$folder/bin
    rm -rf "$root/build/wheels"
    SOURCE_DATE_EPOCH=$(git -C "$root" log -1 --format=%ct 2>/dev/null || echo 315532800)
    export SOURCE_DATE_EPOCH  # the same bits for the same commit
    (cd "$root" && CXX=g++ PATH=$bin:$PATH \
        "$bin/pip" wheel -q --disable-pip-version-check --no-deps --no-build-isolation \
        --config-settings cmake.define.PLIANT_WARNINGS_AS_ERRORS=ON -w build/wheels .)
    PATH=$bin:$PATH "$bin/auditwheel" repair -w "$root/build/dist" "$root"/build/wheels/*.whl \
        >/dev/null 2>&1
    # shellcheck disable=SC2012  # names without blanks
    wheel=$(ls -t "$root"/build/dist/*.whl | head -n 1)
    PATH=$bin:$PATH "$bin/auditwheel" show "$wheel" | sed -n '/is consistent/,$p'
    (($(stat -c %s "$wheel") <= most_wheel_mb << 20)) ||
        fail "wheel: expected at most $most_wheel_mb MB, found $(du -h "$wheel")"
    say "build/dist/${wheel##*/}, $(($(stat -c %s "$wheel") >> 10)) KiB"
}

# The module of build/gcc, without a wheel.
install_module() {
    rm -rf "$root/build/python-module"
    cmake --install "$root/build/gcc" --prefix "$root/build/python-module" --component python \
        >/dev/null
    cp -r "$root"/python/pliant/. "$root/build/python-module/pliant/"
}

api_list() { # --check|--write
    "$root/tools/api_list" "$1" "$root/build/python-module/pliant" "$root/build/gcc/pliant"
}

api() {
    need_packages build test lint wheel
    compile_with_gcc
    install_module
    api_list --write
}

# The module's names, its tests but the long ones, and its types.
test_module() {
    environment test
    local python=$root/build/python-test/bin/python module=$root/build/python-module
    install_module
    api_list --check
    local inputs=("$module" "$root/python/tests" "$root/python/examples" "$root/docs"
        "$root/tests/data")
    export PYTHONPATH=$module MYPYPATH=$module PYTHONDONTWRITEBYTECODE=1
    unless_passed python "${inputs[@]}" -- env -C "$root/python/tests" \
        "$python" -m pytest -q -p no:cacheprovider --ignore=large --durations=8 -n "$(nproc)" \
        $(long_python_tests | sed "s#^#--deselect=python/tests/#") .
    unless_passed python-types "${inputs[@]}" -- env -C "$root/python/tests" \
        "$python" -m mypy --strict --cache-dir="$root/build/mypy" -p pliant
    unless_passed python-use-types "${inputs[@]}" -- env -C "$root/python/tests" \
        "$python" -m mypy --strict --cache-dir="$root/build/mypy" use_types.py
}

# The extension for 3D Slicer, without VTK: its client beside the program of build/gcc.
test_slicer_client() {
    environment test
    local folder=$root/integrations/slicer
    export PLIANT_PROGRAM=$root/build/gcc/pliant PYTHONDONTWRITEBYTECODE=1
    unless_passed slicer "$folder" "$PLIANT_PROGRAM" -- env -C "$folder/tests" \
        "$root/build/python-test/bin/python" -m pytest -q -p no:cacheprovider -n "$(nproc)" \
        test_client.py
}

# All of it, with VTK.
test_slicer() {
    environment slicer "${PLIANT_CACHE:-$root/build}/python-slicer"
    (cd "$root/integrations/slicer/tests" &&
        PLIANT_PROGRAM=$root/build/gcc/pliant PYTHONDONTWRITEBYTECODE=1 \
            "${PLIANT_CACHE:-$root/build}/python-slicer/bin/python" -m pytest -q \
            -p no:cacheprovider .)
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
