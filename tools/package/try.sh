#!/bin/sh
# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# Run in a bare system as root, beside the packages and examples/consumer: installs them, uses them
# and removes them.

set -eu
cd "$(dirname "$0")"
export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8
install="apt-get install -y -q --no-install-recommends"

$install ./pliant_*.deb passwd >/dev/null
useradd --create-home visitor
cat >/home/visitor/try <<'TEXT'
set -eu
cd
pliant --version
pliant phantom airway --size 64 --out airway.nrrd
pliant deform airway.nrrd --push 2.5,-1,-9:6,0,0 --tool sphere:3 --out pushed.nrrd
pliant info pushed.nrrd
pliant serve airway.nrrd --port 8765 >served 2>&1 &
server=$!
for n in $(seq 50); do grep -q http served && break; sleep 0.2; done
grep -o 'http://[^ ]*' served
kill $server
TEXT
su visitor -c 'sh /home/visitor/try'
test -s /usr/share/man/man1/pliant-deform.1 || test -s /usr/share/man/man1/pliant-deform.1.gz

$install ./libpliant-dev_*.deb g++ cmake ninja-build >/dev/null
cmake -S consumer -B built -G Ninja >/dev/null
cmake --build built >/dev/null
built/consumer . --check

apt-get purge -y -q pliant libpliant-dev >/dev/null
if find / -xdev \( -path /proc -o -path /try -o -path /home \) -prune -o -name '*pliant*' -print |
    grep .; then
    echo "left behind" >&2
    exit 1
fi
echo "installed, used, removed"
