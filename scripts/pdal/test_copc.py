"""COPC files: what gable writes follows the specification and is read by PDAL, and the other way round."""

import struct
import unittest
from pathlib import Path

from programs import TILE, Both

ORDER = "X:2,Y:2,Z:2,Intensity:0,ReturnNumber:0,Classification:0,GpsTime:6"


def records(data, place, count, extended):
    """The variable length records from a place on: user, number, where the data starts, and the data."""
    for _ in range(count):
        user, number, length = struct.unpack_from("<16sHQ" if extended else "<16sHH", data, place + 2)
        start = place + (60 if extended else 54)
        yield user.rstrip(b"\0").decode(), number, start, data[start:start + length]
        place = start + length


class Copc(Both):
    def check(self, path):
        """Holds a file against the rules of COPC 1.0; gives the number of nodes."""
        data = Path(path).read_bytes()
        header, offset, vlrs, format_ = struct.unpack_from("<HIIB", data, 94)
        self.assertEqual((data[:4], data[24:26], header), (b"LASF", b"\1\4", 375))
        self.assertIn(format_, {0x86, 0x87, 0x88}, "compressed, of the formats 6 to 8")
        evlr, evlrs, count, *by_return = struct.unpack_from("<QIQ15Q", data, 235)
        self.assertEqual(data[107:131], bytes(24), "the old counts")
        self.assertEqual(sum(by_return), count)
        of_header = list(records(data, 375, vlrs, False))
        self.assertEqual(of_header[-1][2] + len(of_header[-1][3]), offset, "points follow the records")
        user, number, start, info = of_header[0]
        self.assertEqual((user, number, start, len(info)), ("copc", 1, 375 + 54, 160))
        *centre, half, spacing, root, size, first, last = struct.unpack_from("<5d2Q2d", info)
        self.assertEqual(info[72:], bytes(88), "reserved")
        self.assertGreater(spacing, 0)
        self.assertLessEqual(first, last)
        laszip = next(data for user, number, _, data in of_header if (user, number) == ("laszip encoded", 22204))
        self.assertEqual(struct.unpack_from("<H", laszip)[0], 3, "layered chunks")
        self.assertEqual(struct.unpack_from("<I", laszip, 12)[0], 0xFFFFFFFF, "chunks of any size")
        hierarchy = next(of for of in records(data, evlr, evlrs, True) if of[:2] == ("copc", 1000))
        self.assertGreaterEqual(root, hierarchy[2])
        self.assertLessEqual(root + size, hierarchy[2] + len(hierarchy[3]))
        table, = struct.unpack_from("<q", data, offset)
        nodes, pages, place, points = {}, [(root, size)], offset + 8, 0
        chunks = []
        while pages:
            at, size = pages.pop()
            for entry in struct.iter_unpack("<4iQii", data[at:at + size]):
                *key, where, bytes_, number = entry
                if number == -1:
                    pages.append((where, bytes_))
                    continue
                self.assertNotIn(tuple(key), nodes)
                nodes[tuple(key)] = number
                points += number
                if number:
                    chunks.append((where, bytes_))
        self.assertEqual(points, count)
        for level, *axes in nodes:
            self.assertTrue(all(0 <= axis < 2**level for axis in axes))
            if level:
                self.assertIn((level - 1, *(axis // 2 for axis in axes)), nodes, "each node has the one above it")
        for where, bytes_ in sorted(chunks):
            self.assertEqual(where, place, "chunk follows chunk")
            place += bytes_
        self.assertEqual(place, table, "and the table of chunks the last")
        high, low = (struct.unpack_from("<6d", data, 179)[i::2] for i in (0, 1))
        for axis in range(3):
            self.assertLessEqual(centre[axis] - half, low[axis])
            self.assertGreaterEqual(centre[axis] + half, high[axis])
        return len(nodes)

    def text_of(self, program, path, **options):
        """The points that a program reads from a file, as sorted lines."""
        reader = {"type": "readers.copc", "filename": str(path), **options}
        self.run_pipeline(program, [reader, {"type": "writers.text", "filename": "{}.txt", "order": ORDER,
                                            "keep_unspecified": False}])
        return sorted((self.folder / f"{program}.txt").read_text().splitlines())

    def test_both_read_both(self):
        # Twelve of the tile beside one another, so that there are nodes below nodes.
        stages = []
        for i in range(12):
            shift = f"X = X + {i % 4 * 110}", f"Y = Y + {i // 4 * 140}"
            stages += [{"type": "readers.las", "filename": TILE, "tag": f"t{i}"},
                       {"type": "filters.assign", "value": list(shift), "inputs": f"t{i}", "tag": f"s{i}"}]
        stages.append({"type": "filters.merge", "inputs": [f"s{i}" for i in range(12)]})
        self.both([*stages, {"type": "writers.copc", "filename": "{}.copc.laz"}])
        theirs, ours = (self.folder / f"{program}.copc.laz" for program in ("pdal", "gable"))
        self.check(theirs)
        self.assertGreater(self.check(ours), 8)
        corner = {"bounds": "([84950, 85100], [447500, 447560])"}
        for options in ({}, corner):
            texts = [self.text_of(program, path, **options) for program in ("pdal", "gable") for path in (theirs, ours)]
            self.assertGreater(len(texts[0]), 1000)
            self.assertTrue(all(text == texts[0] for text in texts), [len(text) for text in texts])
        # A coarse view, which only PDAL reads: fewer points, and some everywhere.
        coarse = self.text_of("pdal", ours, resolution=4)
        self.assertTrue(1000 < len(coarse) < len(texts[0]) * 10)
        self.assertLess(len(coarse), 12 * 141577 / 4)

    def test_colours_and_further_dimensions(self):
        made = [{"type": "filters.ferry", "dimensions": "Intensity=>Red,Intensity=>Green,Intensity=>Blue"},
                {"type": "filters.assign", "value": "Mark = Z * 2"}]
        writer = {"type": "writers.copc", "filename": "{}.copc.laz", "extra_dims": "all", "a_srs": "EPSG:7415"}
        self.run_pipeline("gable", [TILE, *made, writer])
        path = self.folder / "gable.copc.laz"
        self.check(path)
        _, told = self.run_pipeline("pdal", [{"type": "readers.copc", "filename": str(path)}, {"type": "filters.stats"}])
        reader, stats = told["readers.copc"], told["filters.stats"]
        self.assertEqual((reader["count"], reader["dataformat_id"]), (141577, 7))
        self.assertIn("Amersfoort / RD New", reader["srs"]["wkt"])
        found = {of["name"]: of for of in stats["statistic"]}
        self.assertEqual(found["Red"]["maximum"], found["Intensity"]["maximum"])
        self.assertAlmostEqual(found["Mark"]["average"], 2 * found["Z"]["average"], 2)


if __name__ == "__main__":
    unittest.main()
