#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""What a build is made of, as SPDX 2.3: the library, third-party code, the page's packages.

  sbom.py VERSION OUT.json [PACKAGE-LOCK]   PACKAGE-LOCK where the page is in the build
  sbom.py --self-test

Third-party libraries come from the table of THIRD_PARTY.md, their versions from dpkg where there
is one. The date is SOURCE_DATE_EPOCH, which makes the same file of the same sources; else the
present one.
"""

import base64
import datetime
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
NONE = "NOASSERTION"


def third_party(text: str) -> list[dict]:
    """Rows of libraries that are compiled in or linked."""
    found = []
    for line in text.splitlines():
        row = re.match(
            r"\| \[([^]]+)\]\((\S+?)\)[^|]*\| ([^|]+) \|[^|]*\| ([\w.+-]+) \| (.+?) \|$", line
        )
        if row and row[5] not in ("tests", "benchmarks"):
            name, home, licence, package, component = row.groups()
            found.append(
                {
                    "name": name,
                    "home": home,
                    "licence": re.split("[;,]", licence)[0],
                    "comment": f"{licence}; in {component}",
                    "debian": package,
                }
            )
    return found


def debian_version(package: str) -> str:
    if not shutil.which("dpkg-query"):
        return ""
    query = ["dpkg-query", "-W", "-f", "${db:Status-Status} ${Version}", package]
    status, _, version = subprocess.run(
        query, capture_output=True, text=True, check=False
    ).stdout.partition(" ")
    return version if status == "installed" else ""


def page_packages(lock: dict) -> list[dict]:
    """npm's packages that are bundled, with the hash of what was bundled."""
    found = []
    for place, package in lock["packages"].items():
        if place and not package.get("dev") and not package.get("optional"):
            kind, _, digest = package["integrity"].partition("-")
            found.append(
                {
                    "name": place.removeprefix("node_modules/"),
                    "version": package["version"],
                    "licence": package["license"],
                    "sums": [
                        {"algorithm": kind.upper(), "checksumValue": base64.b64decode(digest).hex()}
                    ],
                }
            )
    return found


def document(version: str, libraries: list[dict], page: list[dict]) -> dict:
    packages = [
        {
            "SPDXID": "SPDXRef-pliant",
            "name": "pliant",
            "versionInfo": version,
            "downloadLocation": NONE,
            "filesAnalyzed": False,
            "licenseConcluded": "Apache-2.0",
            "licenseDeclared": "Apache-2.0",
            "copyrightText": "2026 The Pliant authors",
            "supplier": "Organization: The Pliant authors",
        }
    ]
    links = [
        {
            "spdxElementId": "SPDXRef-DOCUMENT",
            "relationshipType": "DESCRIBES",
            "relatedSpdxElement": "SPDXRef-pliant",
        }
    ]
    for one in [*libraries, *page]:
        identity = "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", one["name"])
        entry = {
            "SPDXID": identity,
            "name": one["name"],
            "versionInfo": one.get("version") or NONE,
            "downloadLocation": NONE,
            "filesAnalyzed": False,
            "licenseConcluded": one["licence"],
            "licenseDeclared": one["licence"],
            "copyrightText": NONE,
        }
        if "home" in one:
            entry |= {"homepage": one["home"], "comment": one["comment"]}
        if "sums" in one:
            entry["checksums"] = one["sums"]
        if one.get("version") and "debian" in one:
            entry["externalRefs"] = [
                {
                    "referenceCategory": "PACKAGE-MANAGER",
                    "referenceType": "purl",
                    "referenceLocator": f"pkg:deb/debian/{one['debian']}@{one['version']}",
                }
            ]
        elif "sums" in one:
            entry["externalRefs"] = [
                {
                    "referenceCategory": "PACKAGE-MANAGER",
                    "referenceType": "purl",
                    "referenceLocator": f"pkg:npm/{one['name']}@{one['version']}",
                }
            ]
        packages.append(entry)
        links.append(
            {
                "spdxElementId": "SPDXRef-pliant",
                "relationshipType": "DEPENDS_ON",
                "relatedSpdxElement": identity,
            }
        )
    when = datetime.datetime.fromtimestamp(
        int(os.environ.get("SOURCE_DATE_EPOCH", time.time())), datetime.timezone.utc
    )
    digest = hashlib.sha256(json.dumps(packages, sort_keys=True).encode()).hexdigest()
    return {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"pliant-{version}",
        "documentNamespace": f"urn:pliant:{version}:{digest}",
        "creationInfo": {
            "created": when.strftime("%Y-%m-%dT%H:%M:%SZ"),
            "creators": ["Tool: pliant-sbom"],
        },
        "packages": packages,
        "relationships": links,
    }


def self_test() -> None:
    rows = third_party((ROOT / "THIRD_PARTY.md").read_text(encoding="utf-8"))
    names = {row["name"] for row in rows}
    assert {"GDCM", "oneTBB", "Boost", "zlib", "Eigen"} <= names, names
    assert not {"GoogleTest", "Embree", "Google Benchmark"} & names, names
    assert all(re.fullmatch(r"[\w.-]+", row["licence"]) for row in rows), rows
    lock = json.loads((ROOT / "viewer/package-lock.json").read_text(encoding="utf-8"))
    assert [p["name"] for p in page_packages(lock)] == ["three", "uqr"], page_packages(lock)
    made = document("1.2.3", rows, page_packages(lock))
    assert len({p["SPDXID"] for p in made["packages"]}) == len(rows) + 3
    print("sbom: tests passed")


def main() -> None:
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    version, out, *lock = sys.argv[1:]
    libraries = third_party((ROOT / "THIRD_PARTY.md").read_text(encoding="utf-8"))
    for one in libraries:
        one["version"] = debian_version(one["debian"])
    page = page_packages(json.loads(Path(lock[0]).read_text(encoding="utf-8"))) if lock else []
    text = json.dumps(document(version, libraries, page), indent=1, ensure_ascii=False)
    Path(out).write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
