"""Entwine Point Tiles: both programs read the same points from a folder, whole, in part and coarsely."""

import json
import struct
import unittest

from programs import TILE, Both

ORDER = "X:3,Y:3,Z:3,Intensity:0,Classification:0,GpsTime:6"
# Doubles: of scaled numbers PDAL 2.8 drops the fraction where nodes are not LAZ.
SCHEMA = [
    {"name": "X", "type": "float", "size": 8},
    {"name": "Y", "type": "float", "size": 8},
    {"name": "Z", "type": "float", "size": 8},
    {"name": "Intensity", "type": "unsigned", "size": 2},
    {"name": "Classification", "type": "unsigned", "size": 1},
    {"name": "GpsTime", "type": "float", "size": 8},
]
CUBE = [84890, 447460, -10, 85050, 447620, 150]


class Ept(Both):
    def points(self):
        """The points of the tile as numbers."""
        stages = [{"type": "filters.decimation", "step": 40},
                  {"type": "writers.text", "filename": "{}.txt", "order": ORDER, "keep_unspecified": False}]
        self.run_pipeline("gable", [TILE, *stages])
        lines = (self.folder / "gable.txt").read_text().splitlines()[1:]
        return [tuple(map(float, line.split(","))) for line in lines]

    def folder_of(self, encoding, points):
        """A folder with three levels: every 16th point in the root, every fourth below, the rest in the third; the hierarchy
        of one node stands in a file of its own."""
        root = self.folder / encoding
        for name in ("ept-data", "ept-hierarchy"):
            (root / name).mkdir(parents=True)
        nodes = {}
        for i, point in enumerate(points):
            level = 0 if i % 16 == 0 else 1 if i % 4 == 0 else 2
            side = (CUBE[3] - CUBE[0]) / 2**level
            key = "-".join(str(n) for n in [level, *(int((point[axis] - CUBE[axis]) // side) for axis in range(3))])
            nodes.setdefault(key, []).append(point)
        for key, of in nodes.items():
            path = root / "ept-data" / key
            if encoding == "binary":
                stored = (struct.pack("<dddHBd", *p[:3], int(p[3]), int(p[4]), p[5]) for p in of)
                path.with_suffix(".bin").write_bytes(b"".join(stored))
            else:
                text = self.folder / "node.txt"
                rows = (",".join([*(f"{n:.3f}" for n in p[:3]), str(int(p[3])), str(int(p[4])), repr(p[5])]) for p in of)
                text.write_text("\n".join(["X,Y,Z,Intensity,Classification,GpsTime", *rows]) + "\n")
                self.run_pipeline("gable", [
                    str(text),
                    {"type": "writers.las", "filename": str(path.with_suffix(".laz")), "dataformat_id": 6, "scale_x": 0.001,
                     "scale_y": 0.001, "scale_z": 0.001},
                ])
        apart = next(key for key in nodes if key.startswith("1-"))
        level, *place = map(int, apart.split("-"))
        below = {key: len(of) for key, of in nodes.items() if [n // 2 for n in list(map(int, key.split("-")))[1:]] == place
                 and key.startswith("2-")}
        whole = {key: len(of) for key, of in nodes.items() if key not in below} | {apart: -1}
        (root / "ept-hierarchy" / "0-0-0-0.json").write_text(json.dumps(whole))
        (root / "ept-hierarchy" / f"{apart}.json").write_text(json.dumps({apart: len(nodes[apart])} | below))
        (root / "ept.json").write_text(json.dumps({
            "bounds": CUBE, "boundsConforming": [84899, 447470, -1, 85008, 447611, 17], "dataType": encoding,
            "hierarchyType": "json", "points": len(points), "schema": SCHEMA, "span": 16, "version": "1.0.0",
            "srs": {"authority": "EPSG", "horizontal": "28992", "vertical": "5709"},
        }))
        return root / "ept.json"

    def read(self, program, path, **options):
        reader = {"type": "readers.ept", "filename": str(path), **options}
        text = {"type": "writers.text", "filename": "{}.txt", "order": ORDER, "keep_unspecified": False}
        self.run_pipeline(program, [reader, text])
        return sorted((self.folder / f"{program}.txt").read_text().splitlines())

    def test_the_same_points(self):
        points = self.points()
        for encoding in ("binary", "laszip"):
            path = self.folder_of(encoding, points)
            sizes = []
            for options in [
                {},
                {"bounds": "([84950, 84990], [447500, 447560])"},
                {"bounds": "([84950, 84990], [447500, 447560], [5, 100])"},
                {"polygon": "POLYGON((84900 447480, 85000 447480, 84950 447600, 84900 447480))"},
                {"resolution": 10},
                {"resolution": 6},
            ]:
                with self.subTest(encoding=encoding, options=options):
                    theirs, ours = (self.read(program, path, **options) for program in ("pdal", "gable"))
                    self.assertEqual(len(theirs), len(ours))
                    self.assertEqual([pair for pair in zip(theirs, ours) if pair[0] != pair[1]][:3], [])
                    sizes.append(len(ours))
            self.assertEqual(sizes[0], len(points) + 1)
            self.assertEqual(len(set(sizes)), len(sizes), sizes)

    def test_the_system(self):
        path = self.folder_of("binary", self.points()[:100])
        (_, of_pdal), (_, of_gable) = self.both([{"type": "readers.ept", "filename": str(path)}, {"type": "filters.stats"}])
        # PDAL has it with the bounds in the metadata of the statistics, in this system.
        self.assertEqual(of_gable["readers.ept"]["srs"]["code"], "EPSG:7415")
        averages = [{of["name"]: of["average"] for of in told["filters.stats"]["statistic"]} for told in (of_pdal, of_gable)]
        for name, average in averages[1].items():
            self.assertAlmostEqual(averages[0][name], average, 3)


if __name__ == "__main__":
    unittest.main()
