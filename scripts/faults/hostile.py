"""Ids, attributes and names that are meant to break out of whatever they are written into."""

import json
import re

from bench import fault_of

TEXTS = (
    "</script><script>alert(1)</script>", "<!--", "]]>", "<img src=x onerror=alert(1)>", "../../../../x", "/etc/passwd", "..",
    "a/b\\c", "con", "a\nb\r\nc", "\t\b\f", "\u0000", "\u001b[31mred", "\u202egnp.exe", "\U0001f3e0\u00e9", "'; DROP TABLE footprints; --", "\"", "\\",
    "%s%n%00", "${jndi:ldap://x}", "{{7*7}}", "NaN", "null", "-0", "1e999", "", " ", "mtllib x", "o x\nf 1 2 3", "__proto__", "constructor",
    "x" * 1_000_000,
)
VALUES = (
    None, True, -(2**63), 2**64, 1e308, -0.0, 12345678901234567890, [], {}, [[[]]], {"a": {"b": [1, None, "</script>"]}}, [1, "a", None],
)
OUTPUTS = ("m.city.json", "m.city.jsonl", "m.gpkg", "m.obj", "m.3dtiles")


def text(case):
    return case.draw.choice(TEXTS) if case.draw.random() < 0.7 else "".join(case.draw.choices("<>/\\&'\"\n\0\u2028.;`$(){}é", k=9))


def footprints(case):
    """The sound footprints with hostile ids, attributes and names of attributes."""
    collection = json.loads(case.bench.sound["small.geojson"])
    for feature in collection["features"]:
        properties = {text(case)[:20_000]: case.draw.choice((text(case), case.draw.choice(VALUES))) for _ in range(4)}
        properties["id"] = text(case)
        feature["properties"] = properties
        feature["id"] = text(case)
    path = case.put(case.draw.choice(("h.geojson", "h <b>.geojson", "h\n.geojson", "h'.geojson")), json.dumps(collection).encode())
    return path


def outputs(case):
    """Footprints into every output, and the model into a page."""
    name = case.draw.choice(OUTPUTS)
    rest = ["--field", "height-field"]
    if case.draw.random() < 0.7:
        rest += ["--id-attribute", "id"]
    if case.draw.random() < 0.5:
        rest += ["--point-cloud-source", text(case).replace("\0", "")[:1000]]
    ended = case.reconstruct(case.sound("tile.laz"), footprints(case), name, rest=rest, codes=(0, 1, 2))
    if ended.code == 1:
        return
    if name.startswith("m.city"):
        page_of(case, case.out / name, ["--report", f"{case.out / name}.report.json"])
        for other in ("c.3dtiles", "c.gpkg", "c.obj"):
            case.judged(["convert", case.out / name, "-o", case.out / other], other)


def models(case):
    """A model of somebody else's with hostile names everywhere."""
    whole = json.loads(case.bench.sound["m.city.json"])
    names = {}
    for old in whole["CityObjects"]:
        new = text(case)[:5000]
        while new in names.values():
            new += "x"
        names[old] = new
    objects = {}
    for old, city_object in whole["CityObjects"].items():
        for relation in ("parents", "children"):
            if relation in city_object:
                city_object[relation] = [names[other] for other in city_object[relation]]
        city_object.setdefault("attributes", {})[text(case)[:5000]] = case.draw.choice((text(case), case.draw.choice(VALUES)))
        for geometry in city_object.get("geometry", []):
            for surface in geometry.get("semantics", {}).get("surfaces", []):
                surface[text(case)[:1000] or "a"] = text(case)
                if case.draw.random() < 0.05:
                    surface["type"] = text(case)[:1000]
        objects[names[old]] = city_object
    whole["CityObjects"] = objects
    whole["metadata"]["title"] = text(case)
    path = case.put("h.city.json", json.dumps(whole).encode())
    case.run(["validate", path])
    page_of(case, path, [])
    for other in ("c.3dtiles", "c.gpkg", "c.obj", "c.city.json", "c.city.jsonl"):
        ended = case.run(["convert", path, "-o", case.out / other])
        made = case.out / other
        if ended.code in (0, 2) and not made.exists() or made.exists() and fault_of(made):
            case.breach(f"half an output, {other}: {made.exists() and fault_of(made)}", ended)


def page_of(case, model, rest):
    """The page holds as many scripts as that of a plain model, and its payload can be read."""
    ended = case.judged(["view", model, "-o", case.out / "v.html", *rest], "v.html")
    if ended.code == 1:
        return
    tags = count_of_tags((case.out / "v.html").read_text())
    if case.bench.tags is None:
        plain = case.put("plain.city.json", case.bench.sound["m.city.json"])
        case.run(["view", plain, "-o", case.out / "plain.html"], codes=(0,))
        case.bench.tags = count_of_tags((case.out / "plain.html").read_text())
    if tags != case.bench.tags:
        case.breach(f"the page has the tags {tags}, that of a plain model {case.bench.tags}", ended)


def count_of_tags(html):
    return [len(re.findall(tag, html, re.IGNORECASE)) for tag in ("<script", "</script", "<img", "<!--", "onerror=alert")]
