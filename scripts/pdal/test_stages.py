"""Stages that both programs have: the same pipeline gives the same points."""

import json
import random
import struct
import unittest

from programs import TILE, Both

# A tile in which nobody has told anything, thinned so that a case takes a second.
BARE = [TILE, {"type": "filters.assign", "value": "Classification = 1"}]


class Stages(Both):
    def same_points(self, *stages, order="X:3,Y:3,Z:3,Classification:0", unequal=0, is_ordered=True):
        """Both write the same text; `unequal` lines of a thousand may differ."""
        writer = {"type": "writers.text", "filename": "{}.txt", "order": order, "keep_unspecified": False}
        self.both([*stages, writer])
        theirs, ours = ((self.folder / f"{program}.txt").read_text().splitlines() for program in ("pdal", "gable"))
        self.assertEqual(len(theirs), len(ours), "number of lines")
        if not is_ordered:
            theirs, ours = sorted(theirs), sorted(ours)
        self.assertGreater(len(ours), 1)
        differing = [(a, b) for a, b in zip(theirs, ours) if a != b]
        self.assertLessEqual(len(differing), unequal * len(ours) / 1000, f"{len(differing)} of {len(ours)}: {differing[:5]}")
        return ours

    def test_smrf(self):
        """Gaps are filled by the eight nearest cells; which they are of several as near as the eighth is left to chance."""
        for options in [{}, {"window": 30, "slope": 0.2}, {"cut": 20}, {"cell": 2, "scalar": 0.5, "threshold": 0.3}]:
            with self.subTest(options=options):
                self.same_points(*BARE, {"type": "filters.smrf", **options}, unequal=0.5)
        options = {"ignore": "Classification[6:6]", "returns": "first,intermediate,only"}
        self.same_points(TILE, {"type": "filters.smrf", **options}, unequal=0.5)

    def test_csf(self):
        for options in [{}, {"resolution": 2, "rigidness": 1}, {"smooth": False, "threshold": 0.2}, {"hdiff": 1, "step": 0.5}]:
            with self.subTest(options=options):
                self.same_points(*BARE, {"type": "filters.csf", **options})

    def test_cluster(self):
        roofs = {"type": "filters.range", "limits": "Classification[6:6]"}
        order = "X:3,Y:3,Z:3,ClusterID:0"
        for options in [{"min_points": 30}, {"tolerance": 0.6, "max_points": 500}, {"is3d": False, "tolerance": 0.5}]:
            with self.subTest(options=options):
                self.same_points(TILE, roofs, {"type": "filters.cluster", **options}, order=order)

    def test_heights_above_triangles(self):
        order = "X:3,Y:3,Z:3,HeightAboveGround:2"
        for options in [{}, {"count": 4}, {"allow_extrapolation": False}]:
            with self.subTest(options=options):
                self.same_points(TILE, {"type": "filters.hag_delaunay", **options}, order=order)

    def test_heights_above_the_nearest(self):
        order = "X:3,Y:3,Z:3,HeightAboveGround:2"
        for options in [{}, {"count": 5}, {"count": 3, "max_distance": 2}]:
            with self.subTest(options=options):
                self.same_points(TILE, {"type": "filters.hag_nn", **options}, order=order)

    def test_decimation(self):
        for options in [{"step": 7}, {"step": 2.6}, {"step": 3, "offset": 100, "limit": 5000}]:
            with self.subTest(options=options):
                self.same_points(TILE, {"type": "filters.decimation", **options})

    def test_returns(self):
        order = "X:3,Y:3,Z:3,ReturnNumber:0,NumberOfReturns:0"
        for groups in ["last", "first,only", "only", "intermediate"]:
            with self.subTest(groups=groups):
                self.same_points(TILE, {"type": "filters.returns", "groups": groups}, order=order)

    def test_sort(self):
        order = "X:3,Y:3,Z:3,Intensity:0,GpsTime:6"
        for options in [{"dimension": "Z"}, {"dimensions": "Classification", "order": "DESC"}]:
            with self.subTest(options=options):
                self.same_points(TILE, {"type": "filters.sort", "algorithm": "STABLE", **options}, order=order)
        # By several dimensions PDAL leaves points that agree in all of them in any order.
        several = {"type": "filters.sort", "dimensions": ["Intensity", "Z"], "order": "DESC"}
        self.same_points(TILE, several, order="Z:3,Intensity:0")

    def test_tail_and_head(self):
        for kind in ("filters.tail", "filters.head"):
            for options in [{}, {"count": 1000}, {"count": 140000, "invert": True}, {"count": 10**6}]:
                with self.subTest(kind=kind, options=options):
                    self.same_points(TILE, {"type": kind, **options})
        # Those that `where` leaves out are a set of their own, which in PDAL comes first.
        self.same_points(TILE, {"type": "filters.tail", "count": 50, "where": "Classification == 6"}, is_ordered=False)

    def overlay(self, crs="urn:ogc:def:crs:EPSG::28992"):
        """Two squares that overlap and one without a value."""
        path = self.folder / "areas.geojson"
        ring = lambda x, y, side: [[x, y], [x + side, y], [x + side, y + side], [x, y + side], [x, y]]
        squares = [(84900.5, 447500.5, 60, 5), (84930.5, 447530.5, 60, 9), (85000.5, 447500.5, 30, 200)]
        features = [
            {"type": "Feature", "properties": {"name": f"n{i}", "value": value},
             "geometry": {"type": "Polygon", "coordinates": [ring(x, y, side)]}}
            for i, (x, y, side, value) in enumerate(squares)
        ]
        path.write_text(json.dumps({"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": crs}},
                                    "features": features}))
        return str(path)

    def test_overlay(self):
        overlay = {"type": "filters.overlay", "datasource": self.overlay(), "column": "value"}
        self.same_points(TILE, overlay | {"dimension": "UserData", "where": "Z > 3"}, order="X:3,Y:3,Z:3,UserData:0")
        self.same_points(TILE, {"type": "filters.ferry", "dimensions": "=>Area"}, overlay | {"dimension": "Area"},
                         order="X:3,Y:3,Z:3,Area:1")

    def test_text(self):
        random.seed(1)
        rows = [[f"{random.uniform(0, 99):.3f}" for _ in range(3)] + [str(random.randrange(9))] for _ in range(500)]
        files = {
            "a.csv": "\n".join(["X,Y,Z,Classification", *(",".join(row) for row in rows)]) + "\n",
            "b.txt": "\n".join(["X Y Z Classification", *("  ".join(row) for row in rows)]),
            "c.txt": "\r\n".join(['"X";"Y";"Z";"Classification"', *(";".join(row) for row in rows)]) + "\r\n",
            "d.txt": "\n".join(["# skipped", "x\ty\tz\tclassification", *("\t".join(row) for row in rows)]) + "\n",
        }
        for name, text in files.items():
            (self.folder / name).write_bytes(text.encode())
        reader = lambda name, **options: {"type": "readers.text", "filename": str(self.folder / name), **options}
        texts = [
            self.same_points(reader("a.csv")),
            self.same_points(reader("b.txt")),
            self.same_points(reader("c.txt")),
            self.same_points(reader("d.txt", skip=1)),
            self.same_points(reader("a.csv", header="X,Y,Z,Classification", skip=1)),
        ]
        self.assertTrue(all(text == texts[0] for text in texts))
        self.same_points(reader("a.csv", count=17))

    def test_ply(self):
        random.seed(2)
        rows = [(random.uniform(0, 99), random.uniform(0, 99), random.uniform(0, 9), random.randrange(255)) for _ in range(300)]
        for encoding in ("ascii", "binary_little_endian", "binary_big_endian"):
            head = ["ply", f"format {encoding} 1.0", "comment a test", f"element vertex {len(rows)}", "property double x",
                    "property double y", "property float z", "property uchar intensity", "element face 0",
                    "property list uchar int vertex_indices", "end_header", ""]
            sign = "<" if "little" in encoding else ">"
            if encoding == "ascii":
                body = "".join(f"{x!r} {y!r} {z!r} {i}\n" for x, y, z, i in rows).encode()
            else:
                body = b"".join(struct.pack(sign + "ddfB", *row) for row in rows)
            path = self.folder / f"{encoding}.ply"
            path.write_bytes("\n".join(head).encode() + body)
            with self.subTest(encoding=encoding):
                self.same_points({"type": "readers.ply", "filename": str(path)}, order="X:4,Y:4,Z:4,Intensity:0")


if __name__ == "__main__":
    unittest.main()
