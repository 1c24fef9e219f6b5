#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# A scan of 512 × 512 × 1024 voxels (537 MB) opened and pushed once: seconds, and the most memory
# that the program had in use, as a multiple of the scan. The page cache, which the system takes
# back when it needs it, counts where the program has mapped it.
#
#   benchmarks/large_scan.sh [PROGRAM [FOLDER]]   by default build/release/pliant and /var/tmp
#
# The scan is made first, and everything is removed at the end: 8 GB of room are needed, or 1.6 GB
# with PLIANT_FIELDS=0, which leaves out the case with displacement field and transform. The figure
# of each case is the median of PLIANT_RUNS runs, by default 3.

set -euo pipefail
export LC_ALL=C
root=$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/..
program=$(readlink -f -- "${1:-$root/build/release/pliant}")
runs=${PLIANT_RUNS:-3}

fail() {
    echo "large_scan.sh: $1" >&2
    exit 2
}
[[ -x $program ]] || fail "$program is missing; ./dev build makes it"
[[ -x /usr/bin/time ]] || fail "/usr/bin/time is missing (package time)"
folder=$(mktemp -d -p "${2:-/var/tmp}" pliant-large-XXXXXX)
trap 'rm -rf -- "$folder"' EXIT
cd -- "$folder"

"$program" phantom vessel --size 512x512x1024 --spacing 0.7,0.7,0.6 --raw --out scan.nrrd \
    >phantom.txt
printf '[material]\nbone_threshold_hu = 3000\n' >soft.toml  # contrast is no bone
push=$(sed -n 's/.*--push "\([^"]*\)".*/\1/p' phantom.txt | head -n 1)
megabytes=$(($(stat -c %s scan.nrrd) / 1000000))

measure() { # NAME ARGUMENT…
    local name=$1 run
    shift
    rm -f times
    for ((run = 0; run < runs; ++run)); do
        /usr/bin/time -a -o times -f '%e %U %S %M' "$program" "$@" >said.txt
        rm -f out.* u.nrrd t.nrrd
    done
    sort -n times | awk -v name="$name" -v scan="$megabytes" '
        { wall[NR] = $1; user[NR] = $2; system_time[NR] = $3; if ($4 > most) most = $4 }
        END {
            m = int((NR + 1) / 2)
            printf "%-44s %6.2f s %6.2f s %6.2f s %6.0f MB %5.2f x\n", name, wall[m], user[m],
                   system_time[m], most * 1.024 / 1000, most * 1.024 / 1000 / scan
        }'
}

printf '%-44s %8s %8s %8s %9s %7s\n' "case (scan: $megabytes MB)" wall user system memory scan
deform=(deform --push="$push" --tool sphere:4 --config soft.toml)
measure "info, raw" info scan.nrrd
measure "pushed, written raw" "${deform[@]}" scan.nrrd --raw --out out.nrrd
measure "pushed, written gzip" "${deform[@]}" scan.nrrd --out out.nrrd
if [[ ${PLIANT_FIELDS:-1} != 0 ]]; then
    measure "pushed, written raw with both fields" "${deform[@]}" scan.nrrd --raw --out out.nrrd \
        --displacement u.nrrd --transform t.nrrd
fi
"$program" "${deform[@]}" scan.nrrd --out packed.nrrd >said.txt
measure "info, gzip" info packed.nrrd
measure "pushed from gzip, written raw" "${deform[@]}" packed.nrrd --raw --out out.nrrd
sed -n 1p said.txt
