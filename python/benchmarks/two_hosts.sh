#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# Three studies on two hosts that a cable joins: network namespaces with a veth pair, each with a
# host name, a temporary folder and a cache of its own. Host b doesn't see the folder of the scans.
# Results go to an object store on host a. A worker is killed in the middle. Each table is compared
# with that of one machine without a network.
#
#   sudo python/benchmarks/two_hosts.sh PYTHON [COUNT]   COUNT augmented scans (default 1000), a
#                                                        tenth of truth cases and fits
#
# PYTHON has pliant, distributed, s3fs, moto, flask and flask-cors.

set -euo pipefail
export LC_ALL=C
python=$(readlink -f -- "$(dirname -- "$1")")/$(basename -- "$1")
count=${2:-1000}
tenth=$(((count + 9) / 10))
work=$(mktemp -d)
a=10.231.77.1 b=10.231.77.2
export AWS_ENDPOINT_URL=http://$a:5000 AWS_ACCESS_KEY_ID=test AWS_SECRET_ACCESS_KEY=test
export AWS_DEFAULT_REGION=us-east-1

finish() {
    # shellcheck disable=SC2046  # one word for each process
    { kill -9 $(jobs -p) && wait; } 2>/dev/null || true
    for host in pliant-a pliant-b; do
        # shellcheck disable=SC2046  # one word for each process
        kill -9 $(ip netns pids $host) 2>/dev/null || true
        ip netns delete $host 2>/dev/null || true
    done
    rm -rf "$work"
}
trap finish EXIT

ip netns add pliant-a
ip netns add pliant-b
ip link add cable-a netns pliant-a type veth peer name cable-b netns pliant-b
ip -n pliant-a address add $a/24 dev cable-a
ip -n pliant-b address add $b/24 dev cable-b
for host in a b; do
    ip -n pliant-$host link set lo up
    ip -n pliant-$host link set cable-$host up
    mkdir -p "$work/tmp-$host" "$work/cache-$host"
done
mkdir "$work/scans"

on() { # HOST COMMAND…: in its network, with its name, folders and mounts
    local host=$1 hide=:
    shift
    [[ $host == a ]] || hide="mount -t tmpfs none $work/scans"
    TMPDIR=$work/tmp-$host PLIANT_STUDY_CACHE=$work/cache-$host \
        ip netns exec pliant-"$host" unshare -m -u \
        sh -c "hostname host-$host; $hide; exec \"\$@\"" sh "$@"
}

worker() { # HOST: started again when it ends
    while :; do
        on "$1" "$python" -m distributed.cli.dask_worker tcp://$a:8786 --nthreads 1 \
            --no-dashboard --no-nanny >>"$work/worker-$1.log" 2>&1 || true
        sleep 1
    done
}

on a "$python" -m moto.server -H $a -p 5000 >"$work/store.log" 2>&1 &
on a "$python" -m distributed.cli.dask_scheduler --host $a --port 8786 --dashboard-address :0 \
    >"$work/scheduler.log" 2>&1 &
worker a &
worker b &
cd "$work"
"$python" - <<'PYTHON'
import pliant

for n, size in enumerate((48, 56, 64)):
    pliant.make_phantom("airway", (size, size, size)).save(f"scans/airway{n}.nrrd")
PYTHON
cat >augment.toml <<TOML
[study]
seed = 1
[parameters]
scan = { scans = "scans/*.nrrd" }
copy = { count = $(((count + 2) / 3)) }
[run]
what = "augment"
pushes = [1, 3]
at = "wall"
TOML
cat >truth.toml <<TOML
[study]
seed = 2
[parameters]
scan = { scans = "scans/*.nrrd" }
case = { count = $(((tenth + 2) / 3)) }
[run]
what = "truth"
motions = 2
[keep]
files = ["moving.nrrd", "forward.nrrd", "case.json"]
TOML
cat >identify.toml <<TOML
[study]
seed = 3
[parameters]
young = { low = 1000, high = 100000, scale = "log" }
poisson = { low = 0.26, high = 0.45 }
[sample]
method = "latin-hypercube"
count = $tenth
[run]
what = "fit"
volume = true
load = ["+z:0,0,-0.5", "+z:0.5,0,0"]
method = ["gauss-newton"]
TOML
for _ in $(seq 50); do
    on a "$python" -c '
import s3fs
system = s3fs.S3FileSystem()
system.exists("bucket") or system.mkdir("bucket")' 2>/dev/null && break
    sleep 0.5
done
sleep 3

sent() { # bytes through the cable
    ip netns exec pliant-a cat /sys/class/net/cable-a/statistics/{rx,tx}_bytes | paste -sd+ | bc
}

for study in augment truth identify; do
    before=$(sent) begun=$(date +%s.%N)
    if [[ $study == augment ]]; then
        (sleep 8 && kill -9 "$(ip netns pids pliant-b | tail -1)") &
    fi
    on a "$python" -m pliant.study run $study.toml --engine dask://$a:8786 \
        --out s3://bucket/$study
    seconds=$(echo "$(date +%s.%N) - $begun" | bc)
    echo "$study: $seconds s, $((($(sent) - before) / 1000)) kB through the cable"
    two=$(on a "$python" -m pliant.study merge $study.toml --out s3://bucket/$study)
    on a "$python" - "$study" <<'PYTHON'
import collections, sys
from pliant.study._merge import manifests_of
from pliant.study._stores import open_store
from pliant.study import Study

name = sys.argv[1]
found = manifests_of(Study.load(f"{name}.toml"), open_store(f"s3://bucket/{name}"))
print("  items of", dict(collections.Counter(m["made"]["host"] for _, m in found)))
PYTHON
    "$python" -m pliant.study run $study.toml --out one-$study >/dev/null
    one=$("$python" -m pliant.study merge $study.toml --out one-$study)
    [[ ${two##* } == "${one##* }" ]] || {
        echo "$study: another table than one machine's" >&2
        exit 1
    }
    echo "  the table is that of one machine: ${one#*table.csv: }"
done
find cache-b -type f -path '*/files/*' -printf '  host b was sent %f, %s bytes\n'
