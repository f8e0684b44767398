"""Runs gable under limits, judges how it ended and what it left, and keeps the counts."""

import json
import os
import random
import shutil
import signal
import sqlite3
import struct
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

# Address space of a run in bytes; a thread of the pool reserves 64 MiB of it and uses little.
ADDRESS_SPACE = 4 << 30
# Memory that a run on the small inputs of the faults may hold at most, bytes.
MEMORY = 600 << 20
# Time that a run may take, seconds. On a busy machine it is processor time, and a run that does nothing for IDLE hangs.
SECONDS = 120
IDLE = 30
LAUNCH = str(Path(__file__).resolve().parent / "launch.py")
PANIC = ("panicked at", "stack backtrace", "overflowed its stack", "RUST_BACKTRACE", "memory allocation of")


class Ended:
    """How a run of gable ended."""

    def __init__(self, command, code, err, out, seconds, memory, cpu):
        self.command, self.code, self.err, self.out = command, code, err, out
        self.seconds, self.memory, self.cpu = seconds, memory, cpu


class Started:
    """A run under way, in a session of its own."""

    def __init__(self, process, command, err, text, result, begun):
        self.process, self.command, self.err, self.text, self.result, self.begun = process, command, err, text, result, begun

    def kill(self):
        """kill -9, at once."""
        os.killpg(self.process.pid, signal.SIGKILL)

    def hangs(self, seconds):
        """Waits for the end; None, or why there is none to be waited for."""
        wait, used = seconds, 0.0
        while True:
            try:
                self.process.wait(wait)
                return None
            except subprocess.TimeoutExpired:
                wait, before, used = IDLE, used, processor_seconds(self.process.pid)
            passed = time.monotonic() - self.begun
            if used > seconds or passed > 20 * seconds:
                return f"no end after {passed:.0f} s, {used:.0f} s of processor time"
            if passed > seconds + IDLE and used < before + 0.05:
                return f"no end after {passed:.0f} s, and nothing done in the last {IDLE} of them"

    @staticmethod
    def said(file):
        with file:
            file.seek(0)
            return file.read().decode(errors="replace")


class Bench:
    """Counts of all cases, by kind."""

    def __init__(self, gable, sound, seed, keep):
        self.gable, self.sound, self.seed, self.keep = gable, sound, seed, keep
        self.counts, self.breaches, self.skipped = {}, [], {}
        self.lock = threading.Lock()

    def of(self, kind):
        return self.counts.setdefault(kind, {"cases": 0, "runs": 0, "seconds": 0.0, "memory": 0, "codes": {}})

    def case(self, kind, number, function):
        """Runs one case in a folder of its own."""
        folder = Path(tempfile.mkdtemp(prefix="gable-fault-"))
        case = Case(self, kind, number, folder)
        before = len(self.breaches)
        try:
            function(case)
            case.look_around()
        except Skip as reason:
            with self.lock:
                self.skipped[kind] = str(reason)
        finally:
            with self.lock:
                self.of(kind)["cases"] += 1
            if len(self.breaches) > before and self.keep:
                shutil.copytree(folder, self.keep / f"{kind.replace(' ', '-')}-{number}", symlinks=True,
                                dirs_exist_ok=True, ignore=lambda _, names: [n for n in names if n.endswith(".fifo")])
            shutil.rmtree(folder, ignore_errors=True)


class Skip(Exception):
    """The machine lacks what a case needs."""


class Case:
    """One case: its folder, its random numbers, and what it runs."""

    def __init__(self, bench, kind, number, folder):
        self.bench, self.kind, self.number, self.folder = bench, kind, number, folder
        self.draw = random.Random(f"{bench.seed} {kind} {number}")
        # So deep that whoever climbs out by a few ".." is still seen.
        self.out = folder / "a" / "b" / "c" / "out"
        self.inputs, self.scratch = folder / "in", folder / "tmp"
        for path in (self.out, self.inputs, self.scratch, folder / "home"):
            path.mkdir(parents=True)
        self.given = {}
        self.was_killed = False

    def breach(self, text, ended=None):
        lines = [f"{self.kind} {self.number}: {text}"]
        if ended:
            lines.append("  " + " ".join(ended.command))
            lines += ["  | " + line for line in ended.err.strip().splitlines()[-6:]]
        lines.append(f"  again: python3 scripts/faults --seed {self.bench.seed} --only '{self.kind}' --case {self.number}")
        with self.bench.lock:
            self.bench.breaches.append((self.kind, "\n".join(lines)))
            print("BREACH " + "\n".join(lines), flush=True)

    def put(self, name, content):
        """An input, which nobody may change."""
        path = self.inputs / name
        path.write_bytes(content)
        self.given[name] = content
        return path

    def sound(self, name):
        """One of the sound inputs, as a file of this case."""
        return self.put(name, self.bench.sound[name])

    def start(self, args, address_space=ADDRESS_SPACE, handles=0, file_size=0, stdin=None, out=None):
        """Starts gable; ends with `end`."""
        command = [str(self.bench.gable), *map(str, args)]
        env = {**os.environ, "TMPDIR": str(self.scratch), "HOME": str(self.folder / "home"), "RUST_BACKTRACE": "0"}
        env.pop("XDG_CACHE_HOME", None)
        err, text, result = tempfile.TemporaryFile(), tempfile.TemporaryFile(), tempfile.mktemp(prefix="gable-ended-")
        limits = map(str, (address_space, handles, file_size))
        process = subprocess.Popen([sys.executable, "-E", "-S", LAUNCH, result, *limits, *command], cwd=self.folder, env=env,
                                   stdin=stdin or subprocess.DEVNULL, stdout=out or text, stderr=err, start_new_session=True)
        return Started(process, command, err, text, result, time.monotonic())

    def end(self, started, codes=(0, 1, 2), seconds=SECONDS, memory=MEMORY, killed=False):
        """Waits for gable and judges how it ended."""
        hangs = started.hangs(seconds)
        if hangs:
            started.kill()
            started.process.wait()
        code, most, cpu = -signal.SIGKILL, 0, 0.0
        if os.path.exists(started.result):
            code, most, cpu = (kind(word) for kind, word in zip((int, int, float), Path(started.result).read_text().split()))
            os.unlink(started.result)
        ended = Ended(started.command, code, started.said(started.err), started.said(started.text),
                      time.monotonic() - started.begun, most, cpu)
        name = "killed" if killed and code == -signal.SIGKILL else "hang" if hangs else str(code)
        with self.bench.lock:
            of_kind = self.bench.of(self.kind)
            of_kind["runs"] += 1
            of_kind["seconds"] = max(of_kind["seconds"], ended.seconds)
            of_kind["memory"] = max(of_kind["memory"], ended.memory)
            of_kind["codes"][name] = of_kind["codes"].get(name, 0) + 1
        if hangs:
            self.breach(hangs, ended)
        elif any(sign in ended.err for sign in PANIC):
            self.breach("a panic", ended)
        elif killed and code == -signal.SIGKILL:
            self.was_killed = True
        elif code not in codes:
            self.breach(f"exit code {code}", ended)
        elif code != 0 and not ended.err.strip() + ended.out.strip():
            self.breach(f"exit code {code} and no word", ended)
        if ended.memory > memory:
            self.breach(f"{ended.memory >> 20} MiB of memory, more than {memory >> 20}", ended)
        return ended

    def run(self, args, codes=(0, 1, 2), seconds=SECONDS, memory=MEMORY, **limits):
        return self.end(self.start(args, **limits), codes, seconds, memory)

    def reconstruct(self, tile, footprints, name="m.city.jsonl", rest=("--field", "height-field"), **limits):
        """A run of the method; what it leaves is judged."""
        return self.judged(["reconstruct", tile, "-f", footprints, "-o", self.out / name, *rest], name, **limits)

    def judged(self, args, name, **limits):
        """A run that writes an output of this name, which is judged."""
        ended = self.run(args, **limits)
        self.judge(ended, self.out / name)
        return ended

    def judge(self, ended, path):
        """What is there under its final name must be whole; success without it is none."""
        if not path.exists():
            if ended.code in (0, 2):
                self.breach(f"exit code {ended.code} and nothing written", ended)
            return
        # Footprints without any model are written all the same, each with its reason; what ends with an error is not.
        # Where it is the report for which there was no room, the model is whole, and --resume goes on from there.
        if ended.code == 1 and "error:" in ended.err and f"{path}.report.json: cannot write" not in ended.err:
            self.breach("an error, and something stands under the final name", ended)
        fault = fault_of(path)
        if fault:
            self.breach(f"half an output, {path.name}: {fault}", ended)
        elif path.name.endswith((".city.json", ".city.jsonl")):
            checked = self.run(["validate", path], codes=(0, 1, 2))
            if checked.code != 0:
                self.breach(f"what was written is not valid:\n{checked.out}", ended)

    def look_around(self):
        """Nothing may be changed or left outside of the output folder."""
        for name, content in self.given.items():
            path = self.inputs / name
            if not path.is_file() or path.read_bytes() != content:
                self.breach(f"the input {name} was changed")
        foreign = [str(path.relative_to(self.folder)) for path in self.folder.rglob("*")
                   if path.parent != self.inputs and not path.is_relative_to(self.out) and not path.is_dir()
                   and not (self.was_killed and path.is_relative_to(self.scratch))]
        foreign += [name.name for name in self.inputs.iterdir() if name.is_file() and name.name not in self.given]
        if foreign:
            self.breach(f"written outside of the output folder: {foreign[:5]}")


def processor_seconds(group):
    """Processor time of the processes of a group that are under way."""
    ticks = 0
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            # The name of a process, which is in brackets, may hold anything.
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[2]) == group:
            ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def fault_of(path):
    """What is wrong with an output as a file of its format; None if it is whole."""
    try:
        if path.is_dir():
            return fault_of_tiles(path)
        if path.suffix == ".gpkg":
            database = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
            found = database.execute("PRAGMA integrity_check").fetchone()[0]
            database.execute("SELECT count(*) FROM footprints").fetchone()
            database.close()
            return None if found == "ok" else found
        content = path.read_bytes()
        if path.suffix == ".jsonl":
            lines = [json.loads(line) for line in content.decode().split("\n") if line]
            return None if lines and lines[0]["type"] == "CityJSON" else "no header"
        if path.suffix == ".json":
            return None if isinstance(json.loads(content), dict) else "no object"
        if path.suffix == ".html":
            return None if content.rstrip().endswith(b"</html>") else "no end"
        if path.suffix == ".obj":
            lines = content.decode().splitlines()
            count = sum(line.startswith("v ") for line in lines)
            used = max((int(part.split("/")[0]) for line in lines if line.startswith("f ") for part in line.split()[1:]),
                       default=0)
            return None if used <= count else f"vertex {used} of {count}"
        return None
    except (ValueError, OSError, KeyError, sqlite3.Error) as error:
        return f"{type(error).__name__}: {error}"


def fault_of_tiles(folder):
    """What is wrong with a folder of 3D Tiles."""

    def contents(tile):
        if "content" in tile:
            yield tile["content"]["uri"]
        for child in tile.get("children", []):
            yield from contents(child)

    waiting = [folder / "tileset.json"]
    while waiting:
        tileset = waiting.pop()
        for uri in contents(json.loads(tileset.read_bytes())["root"]):
            path = (tileset.parent / uri).resolve()
            if not path.is_relative_to(folder.resolve()):
                return f"a content outside of the folder: {uri}"
            if path.suffix == ".json":
                waiting.append(path)
                continue
            magic, _, length = struct.unpack("<4sII", path.read_bytes()[:12])
            if magic != b"glTF" or length != path.stat().st_size:
                return f"{uri} is no whole glTF"
    return None
