"""What may happen around a run: no room, no permission, no end, two at once, a kill."""

import os
import shutil
import sqlite3
import subprocess
import threading
import time

import sound
from bench import Skip, fault_of

OUTPUTS = ("m.city.json", "m.city.jsonl", "m.gpkg", "m.obj", "m.3dtiles")
FAST = ("--field", "height-field")


def whole(case, name, rest=FAST):
    """The arguments of a run over all of the bundled corner, which takes some seconds."""
    tile, footprints = case.sound("whole.laz"), case.sound("whole.geojson")
    return ["reconstruct", tile, "-f", footprints, "-o", case.out / name, *rest]


def full_disk(case):
    """A disk of a few hundred kilobytes; then it grows, and the run goes on."""
    name = case.draw.choice(OUTPUTS)
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={case.draw.choice((16, 64, 200, 500, 900))}k", "none", case.out],
                             capture_output=True)
    if mounted.returncode:
        raise Skip(f"a small disk cannot be mounted: {mounted.stderr.decode().strip()}")
    try:
        args = whole(case, name)
        ended = case.run(args)
        case.judge(ended, case.out / name)
        if ended.code == 1 and not any(word in ended.err.lower() for word in ("space", "full", "storage")):
            case.breach("no word of the full disk", ended)
        subprocess.run(["mount", "-o", "remount,size=64m", case.out], check=True)
        if ended.code == 1:
            case.judge(case.run([*args, "--resume"], codes=(0, 2)), case.out / name)
    finally:
        subprocess.run(["umount", "-l", case.out], check=True)


def file_limit(case):
    """No file may grow beyond a limit."""
    name = case.draw.choice(OUTPUTS)
    ended = case.run(whole(case, name), file_size=case.draw.choice((512, 4096, 30_000, 150_000, 400_000)))
    case.judge(ended, case.out / name)


def two_runs(case):
    """Two runs to one output: one of them says so, or both write the same."""
    name = case.draw.choice(OUTPUTS)
    args = whole(case, name, rest=("--overwrite", *FAST) if case.draw.random() < 0.5 else FAST)
    first = case.start(args)
    time.sleep(case.draw.choice((0, 0, 0.05, 0.3)))
    second = case.start(args)
    ended = [case.end(first), case.end(second)]
    if all(run.code == 1 for run in ended):
        case.breach(f"neither of two runs came through: {ended[1].err}", ended[0])
    case.judge(min(ended, key=lambda run: run.code), case.out / name)


def folder_removed(case):
    """The folder of the output goes while it is written."""
    name = case.draw.choice(OUTPUTS)
    started = case.start(whole(case, name))
    time.sleep(case.draw.uniform(0.05, 2.0))
    was_complete = False
    for number in range(case.draw.choice((1, 1, 3))):
        # It goes at once, so that what it held can be told.
        gone = case.folder / f"gone{number}"
        try:
            os.rename(case.out, gone)
        except FileNotFoundError:
            continue
        was_complete |= (gone / name).exists()
        shutil.rmtree(gone)
        time.sleep(0.1)
    ended = case.end(started)
    # What was complete before is gone for good.
    if not was_complete:
        case.judge(ended, case.out / name)


def input_replaced(case):
    """An input is overwritten, cut off, removed or replaced while it is read."""
    name = case.draw.choice(OUTPUTS[:2])
    args = whole(case, name)
    victim = case.inputs / case.draw.choice(("whole.laz", "whole.laz", "whole.geojson"))
    started = case.start(args)
    time.sleep(case.draw.uniform(0.0, 0.6))
    way = case.draw.randrange(5)
    content = victim.read_bytes()
    if way == 0:
        victim.write_bytes(case.draw.randbytes(50_000))
    elif way == 1:
        os.truncate(victim, case.draw.randrange(len(content)))
    elif way == 2:
        victim.unlink()
    elif way == 3:
        other = case.inputs / "other"
        other.write_bytes(case.bench.sound["tile.laz" if victim.suffix == ".laz" else "small.geojson"])
        os.replace(other, victim)
    else:
        victim.write_bytes(content[::-1])
    ended = case.end(started)
    del case.given[victim.name]
    victim.unlink(missing_ok=True)
    case.judge(ended, case.out / name)


def fifo(case):
    """A FIFO where a file should be: nobody writes to it, or somebody does."""
    pipe = case.inputs / ("p" + case.draw.choice((".laz", ".geojson", ".gpkg", ".city.jsonl", ".ply", ".xyz", ".tif")))
    os.mkfifo(pipe)
    content = case.draw.choice((None, b"", b"garbage", case.bench.sound["m.city.jsonl"], case.bench.sound["tile.laz"]))
    tile, footprints = case.sound("tile.laz"), case.sound("small.geojson")
    out = case.out / "m.city.jsonl"
    way = case.draw.randrange(4)
    if pipe.suffix in (".laz", ".ply", ".xyz"):
        args = [["info", pipe], ["reconstruct", pipe, "-f", footprints, "-o", out], ["view", case.sound("m.city.jsonl"), "-o",
                case.out / "v.html", "--points", pipe], ["info", case.inputs]][way]
    elif pipe.suffix in (".geojson", ".gpkg"):
        args = [["info", pipe], ["reconstruct", tile, "-f", pipe, "-o", out]][way % 2]
    elif pipe.suffix == ".tif":
        args = ["reconstruct", tile, "-f", footprints, "-o", out, "--dtm", pipe]
    else:
        # Models may come from a pipe, which somebody must write to.
        content = content if content is not None else b""
        args = [["validate", pipe], ["convert", pipe, "-o", case.out / "c.gpkg"], ["view", pipe, "-o", case.out / "v.html"],
                ["evaluate", pipe, "--points", tile]][way]

    def feed():
        try:
            with open(pipe, "wb") as end:
                end.write(content)
        except OSError:
            pass

    writer = threading.Thread(target=feed, daemon=True)
    if content is not None:
        writer.start()
    case.run(args, seconds=30)
    if writer.is_alive():
        # Whoever waits for a reader is let go.
        os.close(os.open(pipe, os.O_RDONLY | os.O_NONBLOCK))
        writer.join(5)
    pipe.unlink()
    for path in (out, case.out / "c.gpkg", case.out / "v.html"):
        if path.exists() and fault_of(path):
            case.breach(f"half an output, {path.name}: {fault_of(path)}")


def standard_output(case):
    """The reader of standard output goes away, or is a full device."""
    tile, footprints = case.sound("tile.laz"), case.sound("small.geojson")
    args = ["reconstruct", tile, "-f", footprints, "-o", "-", *FAST]
    if case.draw.random() < 0.4:
        with open("/dev/full", "wb") as full:
            ended = case.run(args, out=full)
        if ended.code == 0:
            case.breach("success on a full device", ended)
        return
    reader, writer = os.pipe()
    started = case.start(args, out=writer)
    os.close(writer)
    os.read(reader, case.draw.choice((1, 100, 3000)))
    os.close(reader)
    case.end(started)


def loops(case):
    """Links that lead back, to themselves, and to nothing."""
    root = case.out / "loops"
    for name in "abcd":
        (root / name).mkdir(parents=True)
        for back in "123":
            (root / name / back).symlink_to("..")
    (root / "self.laz").symlink_to("self.laz")
    (root / "one.laz").symlink_to("two.laz")
    (root / "two.laz").symlink_to("one.laz")
    (root / "nowhere.laz").symlink_to("/nowhere/at/all.laz")
    footprints = case.sound("small.geojson")
    tile = case.sound("tile.laz")
    way = case.draw.randrange(6)
    if way == 5:
        target = case.out / case.draw.choice(("m.city.jsonl", "m.gpkg", "m.3dtiles"))
        target.symlink_to(target.name)
        case.run(["reconstruct", tile, "-f", footprints, "-o", target, "--overwrite", *FAST], seconds=30)
        return
    args = [["info", f"{root}/**/*.laz"], ["info", root], ["info", root / "self.laz"],
            ["reconstruct", f"{root}/**/*.laz", tile, "-f", footprints, "-o", case.out / "m.city.jsonl", *FAST],
            ["validate", root / "self.laz", root / "nowhere.laz"]][way]
    case.run(args, seconds=30)


def few_handles(case):
    """Two thousand tiles, and no more than 64 files open at a time."""
    folder = case.inputs / "tiles"
    folder.mkdir()
    points = sorted(sound.points_of_las(case.bench.sound["many.las"]))
    share = len(points) // 2000
    for number in range(2000):
        (folder / f"t{number:04}.las").write_bytes(sound.las(points[number * share : (number + 1) * share]))
    name = case.draw.choice(OUTPUTS)
    args = ["reconstruct", folder, "-f", case.sound("whole.geojson"), "-o", case.out / name, "--crs", "EPSG:7415", *FAST]
    ended = case.judged(args, name, handles=64, codes=(0, 2))
    if "too many open files" in ended.err.lower():
        case.breach("too many open files", ended)
    shutil.rmtree(folder)


def kill(case):
    """kill -9 at any moment, then --resume: the bytes of an undisturbed run."""
    name = OUTPUTS[case.number % len(OUTPUTS)]
    args = whole(case, name)
    started = case.start(args)
    time.sleep(case.draw.uniform(0.02, 2.5))
    started.kill()
    ended = case.end(started, killed=True)
    # Killed when all was done and it had but to end, a run leaves nothing to go on from.
    is_complete = (case.out / name).exists() and not (case.out / f"{name}.partial").exists()
    if ended.code != 0 and not is_complete:
        # A kill in the last moments finds the whole model under its name.
        if (case.out / name).exists() and fault_of(case.out / name):
            case.breach("half a model stands under the final name after a kill", ended)
        case.judge(case.run([*args, "--resume"], codes=(0,)), case.out / name)
    with case.bench.undisturbed:
        known = case.bench.results.get(name)
        if known is None:
            twin = case.out / "twin"
            case.run([*args[:5], twin / name, *args[6:]], codes=(0,))
            known = case.bench.results[name] = contents(twin / name)
    if contents(case.out / name) != known:
        case.breach(f"{name} differs from an undisturbed run")
    left = [path.name for path in case.out.iterdir() if ".partial" in path.name or path.suffix == ".part"]
    if left:
        case.breach(f"{left} stay beside {name}")


def contents(path):
    files = [path] if path.is_file() else sorted(p for p in path.rglob("*") if p.is_file())
    return [(str(p.relative_to(path)), p.read_bytes()) for p in files]


def endless(case):
    """Views of a GeoPackage without an end, and devices."""
    rows = "WITH RECURSIVE r(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM r) SELECT i AS fid, "
    views = [rows + "randomblob(1000) AS geom FROM r", rows + "x'00' AS geom FROM r WHERE i < 0"]
    if case.number % 3 == 2:
        case.run(["validate", "/dev/zero"], codes=(1,), seconds=30)
        return
    path = case.inputs / "endless.gpkg"
    database = sqlite3.connect(path)
    database.executescript(
        "CREATE TABLE gpkg_contents (table_name TEXT, data_type TEXT, srs_id INTEGER);"
        "CREATE TABLE gpkg_geometry_columns (table_name TEXT, column_name TEXT, geometry_type_name TEXT, srs_id INT);"
        "INSERT INTO gpkg_contents VALUES ('v', 'features', 0);"
        "INSERT INTO gpkg_geometry_columns VALUES ('v', 'geom', 'POLYGON', 0);"
        f"CREATE VIEW v AS {views[case.number % 3]};"
    )
    database.close()
    case.given[path.name] = path.read_bytes()
    case.run(["info", path], codes=(1,), memory=1300 << 20)
