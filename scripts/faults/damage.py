"""Damaged inputs of every format."""

import struct

# Names of files that belong to one input.
WITH = {"f.shp": ("f.shx", "f.dbf", "f.prj")}
EXTREME = (0xFFFFFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFF, 0x10000000, 0x00FFFFFF, 0xFFFFFFFFFFFFFFFF, 0x7FFFFFFFFFFFFFFF)


def flip(draw, content):
    """Up to four bits, half of them in the first kilobyte."""
    damaged = bytearray(content)
    for _ in range(draw.choice((1, 1, 2, 4))):
        at = draw.randrange(min(1024, len(damaged)) if draw.random() < 0.5 else len(damaged))
        damaged[at] ^= 1 << draw.randrange(8)
    return bytes(damaged)


def block(draw, content):
    """A block of one byte or of noise."""
    damaged = bytearray(content)
    length = min(len(damaged) - 1, draw.choice((16, 512, 4096, 60_000)))
    at = draw.randrange(len(damaged) - length)
    damaged[at : at + length] = draw.choice((b"\0" * length, b"\xff" * length, draw.randbytes(length)))
    return bytes(damaged)


def cut(draw, content):
    """Cut off; one in four within the first half kilobyte."""
    return content[: draw.randrange(min(512, len(content)) if draw.random() < 0.25 else len(content))]


def swap(draw, content):
    """A piece that stands elsewhere, or twice: lengths and offsets lie."""
    length = draw.randrange(1, min(2048, len(content) // 4))
    here, there = draw.randrange(len(content) - length), draw.randrange(len(content))
    return content[:there] + content[here : here + length] + content[there + draw.choice((0, length)) :]


def bomb(draw, content):
    """Counts, lengths and offsets at the head or the foot of a file beyond all measure."""
    damaged = bytearray(content)
    for _ in range(draw.choice((1, 1, 2))):
        form = draw.choice(("<H", "<I", "<I", "<I", "<Q", ">I"))
        size = struct.calcsize(form)
        span = min(400, len(damaged) - size)
        at = draw.randrange(span) if draw.random() < 0.7 else len(damaged) - size - draw.randrange(span)
        struct.pack_into(form, damaged, at, draw.choice(EXTREME) & (256**size - 1))
    return bytes(damaged)


def digits(draw, content):
    """A number in a text made very long, negative, or no number."""
    places = [i for i in range(len(content)) if content[i : i + 1].isdigit()]
    if not places:
        return flip(draw, content)
    at = draw.choice(places)
    new = draw.choice((b"1e308", b"-1", b"99999999999999999999", b"NaN", b"null", b"\"", b"[[[[", b"1" * 400, b"0x1"))
    return content[:at] + new + content[at + 1 :]


WAYS = {"flips": flip, "blocks": block, "cuts": cut, "swaps": swap, "bombs": bomb}


def case_of(way, name):
    """A case with a damaged input of this name."""

    def run(case):
        change = WAYS[way]
        content = case.bench.sound[name]
        others = [other for other in WITH.get(name, ()) if other in case.bench.sound]
        damaged = case.draw.choice((name, *others))
        is_text = name.endswith((".json", ".geojson", ".jsonl", ".xyz"))
        if is_text and way in ("bombs", "swaps") and case.draw.random() < 0.7:
            change = digits
        for other in (name, *others):
            content = case.bench.sound[other]
            case.put(other, change(case.draw, content) if other == damaged else content)
        read(case, name)

    return run


def read(case, name):
    """Reads an input of this name in one of the ways in which such inputs are read."""
    path = case.inputs / name
    space = {"address_space": 3 << 30}
    way = case.draw.randrange(4)
    # SQLite has bounds of its own, see docs/known-limits.md.
    memory = {"memory": 1300 << 20} if name.endswith(".gpkg") else {}
    if name.startswith("tile"):
        if way == 0:
            case.run(["info", path], **space)
        elif way == 1 and name.endswith(("laz", "las")):
            everything = f'["{path}", {{"type": "filters.head", "count": 1000000}}, {{"type": "writers.null"}}]'
            pipeline = case.put("all.json", everything.encode())
            case.run(["pipeline", pipeline], **space)
        else:
            rest = ["--field", "height-field"]
            if name.endswith((".ply", ".xyz")):
                rest += ["--crs", "EPSG:7415"]
            case.reconstruct(path, case.sound("small.geojson"), rest=rest, **space)
    elif name.startswith("f."):
        if way == 0:
            case.run(["info", path], **memory, **space)
        else:
            rest = ["--field", "height-field", *([] if name.endswith((".geojson", ".gpkg")) else ["--footprint-crs", "EPSG:28992"])]
            case.reconstruct(case.sound("tile.laz"), path, rest=rest, **memory, **space)
    elif name.startswith("m."):
        if way == 0:
            case.run(["validate", path], **space)
        elif way == 2 and case.draw.random() < 0.5:
            case.run(["evaluate", path, "--points", case.sound("tile.laz")], **space)
        elif way == 1:
            case.judged(["view", path, "-o", case.out / "v.html"], "v.html", **space)
        else:
            to = case.draw.choice(("c.city.jsonl", "c.gpkg", "c.obj", "c.3dtiles"))
            convert(case, path, to, **space)
    elif name.endswith(".safetensors"):
        case.reconstruct(case.sound("tile.laz"), case.sound("small.geojson"), rest=["--model", path], **space)
    elif name.endswith(".tif"):
        case.reconstruct(case.sound("tile.laz"), case.sound("small.geojson"), rest=["--field", "height-field", "--dtm", path], **space)
    elif name.endswith(".json"):
        case.run(["pipeline", path], **space)


def convert(case, path, to, **limits):
    """Converts a model that may be bad: what comes out must be whole, and need not be valid."""
    from bench import fault_of

    ended = case.run(["convert", path, "-o", case.out / to], **limits)
    made = case.out / to
    if made.exists():
        fault = fault_of(made)
        if fault or ended.code == 1:
            case.breach(f"half an output, {to}: {fault}", ended)
    elif ended.code in (0, 2):
        case.breach(f"exit code {ended.code} and nothing written", ended)
