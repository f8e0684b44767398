#!/usr/bin/env python3
"""Makes what a release consists of, in out/release: an archive for this kind of machine, and checksums.

    scripts/release.py [--binary FILE]

The archive holds the stripped command, the C library with its header, completions, manual pages, the licences of all crates
in it (THIRD-PARTY.txt) and a bill of materials (CycloneDX 1.5, sbom.cdx.json); what a Debian package needs of them lies
beside it (`cargo deb --profile dist`). The same sources give the same archive but for
what the compiler makes; its times are those of the last commit, or $SOURCE_DATE_EPOCH. Without --binary the profile `dist` is
built.
"""

import argparse
import gzip
import hashlib
import io
import json
import os
import platform
import subprocess
import sys
import tarfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "release"
TEXTS = ("license", "licence", "copying", "notice", "copyright", "unlicense")
SHELLS = {"bash": "gable.bash", "zsh": "_gable", "fish": "gable.fish"}


def run(*command: object) -> str:
    return subprocess.run([str(word) for word in command], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def crates() -> list[dict]:
    """The crates that the command is linked from, with those that only build it left out."""
    host = next(line.split()[1] for line in run("rustc", "-vV").splitlines() if line.startswith("host:"))
    metadata = json.loads(run("cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", host))
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    found, left = set(), [metadata["resolve"]["root"]]
    while left:
        this = left.pop()
        if this not in found:
            found.add(this)
            left += [dep["pkg"] for dep in nodes[this]["deps"] if any(kind["kind"] is None for kind in dep["dep_kinds"])]
    return sorted((packages[id] for id in found), key=lambda package: (package["name"], package["version"]))


def third_party(packages: list[dict]) -> str:
    """The licence of every crate, and the texts that come with it."""
    parts = ["gable is made of these crates, each under its own licence.\n"]
    for package in packages:
        if not package["source"]:
            continue
        title = f"{package['name']} {package['version']} ({package['license']})"
        parts.append(f"\n{'=' * 100}\n{title}\n{package.get('repository') or ''}\n{'=' * 100}\n")
        folder = Path(package["manifest_path"]).parent
        texts = sorted(file for file in folder.iterdir() if file.is_file() and file.name.lower().startswith(TEXTS))
        for file in texts:
            parts.append(f"\n--- {file.name}\n\n{file.read_text(encoding='utf-8', errors='replace').rstrip()}\n")
        if not texts:
            parts.append(f"\nThe crate brings no text; {package['license']} is as https://spdx.org/licenses has it.\n")
    return "".join(parts)


def bill(packages: list[dict], version: str) -> str:
    """The bill of materials (CycloneDX 1.5)."""
    with (ROOT / "Cargo.lock").open("rb") as file:
        sums = {(p["name"], p["version"]): p.get("checksum") for p in tomllib.load(file)["package"]}

    def component(package: dict) -> dict:
        name, version = package["name"], package["version"]
        purl = f"pkg:cargo/{name}@{version}"
        found = {"type": "library", "bom-ref": purl, "name": name, "version": version, "purl": purl,
                 "licenses": [{"expression": package["license"].replace("/", " OR ")}]}
        checksum = sums.get((name, version))
        return found | ({"hashes": [{"alg": "SHA-256", "content": checksum}]} if checksum else {})

    whole = {"type": "application", "bom-ref": "gable", "name": "gable", "version": version, "purl": f"pkg:cargo/gable@{version}"}
    document = {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1, "metadata": {"component": whole},
                "components": [component(package) for package in packages if package["source"]]}
    return json.dumps(document, indent=1, sort_keys=True) + "\n"


def archive(path: Path, top: str, files: dict[str, bytes], time: int) -> None:
    """A tar archive whose bytes depend on the files alone."""
    with path.open("wb") as raw, gzip.GzipFile("", "wb", fileobj=raw, mtime=time) as packed:
        with tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as tar:
            for name in sorted(files):
                entry = tarfile.TarInfo(f"{top}/{name}")
                entry.size, entry.mtime = len(files[name]), time
                entry.mode = 0o755 if name.startswith("bin/") or name.endswith(".so") else 0o644
                tar.addfile(entry, io.BytesIO(files[name]))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--binary", type=Path, help="a command that was built before; the C library is beside it")
    options = parser.parse_args()
    if not options.binary:
        subprocess.run(["cargo", "build", "--profile", "dist", "--locked"], cwd=ROOT, check=True)
        target = Path(json.loads(run("cargo", "metadata", "--no-deps", "--format-version", "1"))["target_directory"])
        options.binary = target / "dist" / "gable"
    binary = options.binary.resolve()
    version = run(binary, "-V").split()[1]
    time = int(os.environ.get("SOURCE_DATE_EPOCH") or run("git", "log", "-1", "--format=%ct"))
    packages = crates()

    OUT.mkdir(parents=True, exist_ok=True)
    files = {"bin/gable": binary.read_bytes(), "THIRD-PARTY.txt": third_party(packages).encode(),
             "sbom.cdx.json": bill(packages, version).encode()}
    library = binary.with_name("libgable.so")
    if library.exists():
        files["lib/libgable.so"] = library.read_bytes()
        files["include/gable.h"] = (ROOT / "include" / "gable.h").read_bytes()
        for name in ("CMakeLists.txt", "Lod2Writer.cpp"):
            files[f"pdal/{name}"] = (ROOT / "pdal" / name).read_bytes()
    for name in ("README.md", "CHANGELOG.md", "LICENSE-MIT", "LICENSE-APACHE"):
        files[name] = (ROOT / name).read_bytes()
    (OUT / "THIRD-PARTY.txt").write_bytes(files["THIRD-PARTY.txt"])
    completions = OUT / "completions"
    completions.mkdir(exist_ok=True)
    for shell, name in SHELLS.items():
        script = run(binary, "completions", shell).encode()
        (completions / name).write_bytes(script)
        files[f"share/completions/{name}"] = script
    pages = OUT / "man"
    subprocess.run([binary, "man", pages], check=True, stderr=subprocess.DEVNULL)
    for page in sorted(pages.iterdir()):
        files[f"share/man/man1/{page.name}"] = page.read_bytes()

    name = f"gable-{version}-{platform.machine()}-{platform.system().lower()}"
    path = OUT / f"{name}.tar.gz"
    archive(path, name, files, time)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    (OUT / "SHA256SUMS").write_text(f"{digest}  {path.name}\n")
    print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1e6:.1f} MB, {len(files)} files, {len(packages) - 1} crates")
    print(f"bin/gable: {len(files['bin/gable']) / 1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
