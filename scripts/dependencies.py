#!/usr/bin/env python3
"""Holds the crates that gable is made of against two rules: only permissive licences, and no known vulnerability.

    scripts/dependencies.py [--advisories FOLDER]

Licences are those that `cargo metadata` tells, of all crates in Cargo.lock. Advisories are those of RustSec
(https://github.com/rustsec/advisory-db): a checkout of it in FOLDER or $ADVISORY_DB, or one that is cloned into .tools;
where there is none and none can be fetched, that check is skipped and says so. `cargo deny check` would do the same, but
takes longer to build than all else here to run.

Exit codes: 0 nothing found, 1 something found. What is only unmaintained or unsound is told and is no fault.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

PERMISSIVE = {
    "0BSD", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BlueOak-1.0.0", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0",
    "CC0-1.0", "CDLA-Permissive-2.0", "ISC", "MIT", "MIT-0", "Unicode-3.0", "Unlicense", "Zlib",
}
DATABASE = "https://github.com/rustsec/advisory-db"
ROOT = Path(__file__).resolve().parent.parent


def is_permissive(expression: str) -> bool:
    """Whether an SPDX expression can be met with permissive licences alone; `/` is an old way to write OR."""
    words = re.findall(r"\(|\)|[^\s()]+", expression.replace("/", " OR "))
    place = 0

    def peek() -> str:
        return words[place] if place < len(words) else ""

    def take() -> str:
        nonlocal place
        place += 1
        return words[place - 1] if place <= len(words) else ""

    def any_of() -> bool:
        met = all_of()
        while peek() == "OR":
            take()
            met = all_of() or met
        return met

    def all_of() -> bool:
        met = one()
        while peek() == "AND":
            take()
            met = one() and met
        return met

    def one() -> bool:
        word = take()
        if word == "(":
            met = any_of()
            take()
            return met
        if peek() == "WITH":
            take()
            word = f"{word} WITH {take()}"
        return word in PERMISSIVE

    return bool(words) and any_of() and place == len(words)


def parsed(version: str) -> tuple:
    """A version that can be compared: a pre-release comes before its release."""
    release, _, pre = version.split("+")[0].partition("-")
    numbers = [int(part) for part in release.split(".")]
    numbers += [0] * (3 - len(numbers))
    marks = [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in pre.split(".")] if pre else []
    return (*numbers, not pre, tuple(marks))


def satisfies(version: str, requirement: str) -> bool:
    """Whether a version meets a requirement of Cargo, such as `>= 1.2, < 2` or `^0.3.1`."""
    return all(meets(version, part.strip()) for part in requirement.split(",") if part.strip() not in ("", "*"))


def meets(version: str, comparator: str) -> bool:
    operator, wanted = re.fullmatch(r"(>=|<=|>|<|=|\^|~)?\s*(\S+)", comparator).groups()
    given, bound = parsed(version), parsed(wanted)
    if operator in (">=", "<=", ">", "<", "="):
        return {">=": given >= bound, "<=": given <= bound, ">": given > bound, "<": given < bound, "=": given == bound}[operator]
    parts = [int(part) for part in wanted.split("-")[0].split("+")[0].split(".")]
    # The first part that must stay: for ^ the first that is not 0, for ~ the second.
    fixed = min(1, len(parts) - 1) if operator == "~" else next((i for i, part in enumerate(parts) if part), len(parts) - 1)
    upper = parts[: fixed + 1]
    upper[-1] += 1
    return bound <= given < parsed(".".join(map(str, upper + [0] * (3 - len(upper)))) + "-0")


def crates() -> list:
    command = ["cargo", "metadata", "--locked", "--format-version", "1"]
    told = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return json.loads(told)["packages"]


def licence_faults(packages: list) -> list:
    faults = []
    for package in packages:
        licence = package["license"] or ""
        if not is_permissive(licence):
            faults.append(f"{package['name']} {package['version']}: licence {licence or 'not stated'!r} is not permissive")
    return faults


def database(given: str | None) -> Path | None:
    folder = Path(given) if given else ROOT / ".tools" / "advisory-db"
    if (folder / "crates").is_dir():
        return folder
    if given:
        sys.exit(f"{folder}: no folder \"crates\", as a checkout of {DATABASE} has")
    command = ["git", "clone", "--quiet", "--depth", "1", DATABASE, str(folder)]
    try:
        subprocess.run(command, check=True, capture_output=True, timeout=120)
    except (OSError, subprocess.SubprocessError) as error:
        said = (getattr(error, "stderr", None) or b"").decode(errors="replace").strip() or str(error)
        print(f"advisories: skipped, {DATABASE} cannot be fetched ({said})")
        return None
    return folder


def advisory_faults(packages: list, folder: Path) -> list:
    faults, notes = [], []
    versions = {}
    for package in packages:
        versions.setdefault(package["name"], set()).add(package["version"])
    for name, used in sorted(versions.items()):
        for file in sorted((folder / "crates" / name).glob("*.md")):
            front = re.search(r"```toml\n(.*?)```", file.read_text(encoding="utf-8"), re.DOTALL)
            advisory = tomllib.loads(front.group(1)) if front else {}
            head, known = advisory.get("advisory", {}), advisory.get("versions", {})
            if head.get("withdrawn"):
                continue
            safe = known.get("patched", []) + known.get("unaffected", [])
            for version in sorted(used):
                if not any(satisfies(version, requirement) for requirement in safe):
                    line = f"{name} {version}: {head.get('id', file.stem)} {head.get('informational', '')}".rstrip()
                    (notes if head.get("informational") else faults).append(line)
    for note in notes:
        print(f"advisories: {note}")
    return faults


def test() -> None:
    assert is_permissive("MIT OR GPL-3.0") and is_permissive("(MIT OR Apache-2.0) AND Unicode-3.0") and is_permissive("MIT/Apache-2.0")
    assert not is_permissive("GPL-3.0-only") and not is_permissive("MIT AND GPL-2.0") and not is_permissive("")
    assert not is_permissive("MIT OR") and is_permissive("Apache-2.0 WITH LLVM-exception")
    assert satisfies("1.2.3", ">= 1.2, < 2") and satisfies("0.3.4", "^0.3.1") and not satisfies("0.4.0", "^0.3.1")
    assert not satisfies("1.0.0-rc.1", ">= 1.0.0") and satisfies("1.2.9", "~1.2.3") and not satisfies("1.3.0", "~1.2.3")
    assert satisfies("2.5.0", "2") and not satisfies("3.0.0", "2") and satisfies("0.0.3", "^0.0.3") and not satisfies("0.0.4", "^0.0.3")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--advisories", metavar="FOLDER", default=os.environ.get("ADVISORY_DB"))
    arguments = parser.parse_args()
    test()
    packages = [package for package in crates() if package["source"]]
    faults = licence_faults(packages)
    print(f"licences: {len(packages)} crates, {len(faults)} not permissive")
    folder = database(arguments.advisories)
    if folder:
        found = advisory_faults(packages, folder)
        print(f"advisories: {len(packages)} crates, {len(found)} vulnerabilities")
        faults += found
    for fault in faults:
        print(f"fault: {fault}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
