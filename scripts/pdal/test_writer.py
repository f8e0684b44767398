"""The plugin: `writers.lod2` in PDAL gives what the stage of that name in `gable pipeline` gives."""

import json
import re
import unittest

from programs import FOOTPRINTS, ROOT, TILE, Both

# What a stage is told beside its own options.
OF_STAGES = {"type", "tag", "inputs", "where", "user_data"}


def writer(**options):
    return {"type": "writers.lod2", "filename": "{}.city.json", "field": "height-field", **options}


class Writer(Both):
    def same_model(self, *stages):
        told = [metadata for _, metadata in self.both(list(stages))]
        self.same_bytes(".city.json")
        return told

    def test_options(self):
        """`pdal --options` shows all options of the stage, with their help and their defaults."""
        schema = json.loads((ROOT / "schemas" / "pipeline.schema.json").read_text(encoding="utf-8"))
        expected = {name: of for name, of in schema["$defs"]["writers.lod2"]["properties"].items() if name not in OF_STAGES}
        code, text = self.call("pdal", "--options", "writers.lod2", "--showjson")
        self.assertEqual(code, 0, text)
        shown = {option["name"]: option for option in json.loads(text)[1]}
        self.assertEqual(set(expected) - set(shown), set())
        self.assertLessEqual(set(shown) - set(expected), {"where", "where_merge", "user_data", "log", "option_file"})
        for name, of in expected.items():
            self.assertTrue(shown[name]["description"].startswith(of["description"]), shown[name])
            default = of.get("default")
            text = "" if default is None else default if isinstance(default, str) else json.dumps(default)
            self.assertEqual(shown[name].get("default", ""), text, name)
        _, text = self.call("pdal", "--options", "writers.lod2")
        self.assertIn("Building footprints: GeoPackage", text)
        _, text = self.call("pdal", "--drivers")
        self.assertRegex(text, r"writers\.lod2 +Reconstruct")

    def test_a_tile(self):
        """The quick start, with the network: the model and what the stage has to tell."""
        stage = writer(footprints=FOOTPRINTS)
        del stage["field"]
        told = self.same_model(TILE, stage)
        of_pdal, of_gable = (metadata["writers.lod2"] for metadata in told)
        self.assertEqual((of_pdal["counts"], of_pdal["exit_code"]), (of_gable["counts"], 0))
        self.assertEqual(of_pdal["filename"], [name.replace("/gable.", "/pdal.") for name in of_gable["filename"]])
        model = json.loads((self.folder / "pdal.city.json").read_text(encoding="utf-8"))
        self.assertTrue(model["metadata"]["referenceSystem"].endswith("/EPSG/0/7415"))
        self.assertEqual(sum(of["type"] == "Building" for of in model["CityObjects"].values()), 71)

    def test_filters_that_stream(self):
        """Points come one by one: flags, classes and returns are heeded."""
        self.same_model(
            TILE,
            {"type": "filters.assign", "value": ["Withheld = 1 WHERE X > 84990", "Synthetic = 1 WHERE Y > 447570"]},
            {"type": "filters.expression", "expression": "Classification == 2 || Classification == 6"},
            writer(
                footprints=FOOTPRINTS,
                lod=["1.2", "2.2"],
                title='A "title" with \\ and ü',
                minimum_area=2,
                building_class=[6, 26],
            ),
        )

    def test_several_views(self):
        """Points come view by view, in chunks."""
        _, told = self.same_model(
            TILE, {"type": "filters.splitter", "length": 60}, writer(footprints=FOOTPRINTS, lod="1.2")
        )
        self.assertGreater(told["writers.lod2"]["counts"]["solids_lod12"], 60)

    def test_where(self):
        self.same_model(TILE, writer(footprints=FOOTPRINTS, where="Classification == 2 || Z > 8", lod="1.2"))

    def test_without_footprints(self):
        """Objects are called after the points."""
        self.same_model(
            {"type": "readers.las", "filename": TILE, "count": 60000},
            writer(no_footprint=True, title="some points", crs="EPSG:7415", lod="0"),
        )

    def test_no_building_has_a_model(self):
        """Exit code 1 there, an error here; the model is written all the same."""
        stages = [
            {"type": "readers.las", "filename": TILE},
            {"type": "filters.assign", "value": "Classification = 1"},
            writer(footprints=FOOTPRINTS),
        ]
        (text, _), _ = self.both(stages, code=1)
        self.assertIn("writers.lod2: ", text)

    def refused(self, stages, *parts):
        """Both refuse the pipeline in words that match."""
        for text, _ in self.both(stages, code=1):
            for part in parts:
                self.assertRegex(text, part)

    def test_errors_are_told_in_the_same_words(self):
        footprints = {"footprints": FOOTPRINTS}
        cases = [
            ({}, "found neither `footprints` nor `no_footprint`"),
            ({"footprints": str(self.folder / "none.gpkg")}, r"none\.gpkg"),
            (footprints | {"crs": "EPSG:99999"}, "99999"),
            (footprints | {"lambda": -1}, "found .*-1.* as `lambda`, expected a number from 0 to 1000"),
            (footprints | {"field": "guess"}, "found \"guess\" as `field`, expected one of neural"),
            (footprints | {"overwrite": "perhaps"}, "found \"perhaps\" as `overwrite`, expected true or false"),
            (footprints | {"lod": "7"}, "found `7` as `lod`"),
            (footprints | {"no_footprint": True}, "found both `footprints` and `no_footprint`"),
            (footprints | {"layer": "houses"}, "houses"),
            ({"layer": "houses", "no_footprint": True}, "found `layer` without `footprints`"),
            (footprints | {"filename": "{}.doc"}, r"\.doc"),
        ]
        for options, part in cases:
            with self.subTest(options=options):
                self.refused([TILE, writer() | options], part)

    def test_an_unknown_option(self):
        (of_pdal, _), (of_gable, _) = self.both([TILE, writer(footprints=FOOTPRINTS, lamda=1)], code=1)
        self.assertIn("Unexpected argument 'lamda'", of_pdal)
        self.assertIn("lamda", of_gable)

    def test_points_without_a_crs(self):
        self.refused([{"type": "readers.las", "filename": TILE, "nosrs": True}, writer(footprints=FOOTPRINTS)], "no coordinate reference system")

    def test_points_of_two_systems(self):
        other = {"type": "readers.las", "filename": TILE, "override_srs": "EPSG:28992"}
        self.refused(
            [TILE, other, {"type": "filters.expression", "expression": "Z > 0"}, writer(footprints=FOOTPRINTS)],
            "found points in .* among points in .*, expected points of one CRS",
        )

    def test_a_file_that_exists_is_spared(self):
        for program in ("pdal", "gable"):
            (self.folder / f"{program}.city.json").write_text("mine", encoding="utf-8")
        self.refused([TILE, writer(footprints=FOOTPRINTS, lod="0")], "found a file of that name")
        self.assertEqual((self.folder / "pdal.city.json").read_text(encoding="utf-8"), "mine")
        self.same_model(TILE, writer(footprints=FOOTPRINTS, lod="0", overwrite=True))

    def test_warnings_go_to_the_log(self):
        """PDAL's log has them, the progress at level 3."""
        pipeline = self.folder / "pipeline.json"
        stages = [TILE, writer(footprints=FOOTPRINTS, filename=str(self.folder / "a.city.json"), lod="0")]
        pipeline.write_text(json.dumps(stages), encoding="utf-8")
        code, text = self.call("pdal", "pipeline", pipeline, "--verbose", "3")
        self.assertEqual(code, 0, text)
        self.assertTrue(re.search(r"\(pdal pipeline writers\.lod2 Info\) 71 buildings", text), text)

    def test_validation(self):
        pipeline = self.folder / "pipeline.json"
        for options, valid in [({"footprints": FOOTPRINTS}, True), ({}, False)]:
            pipeline.write_text(json.dumps([TILE, writer(**options)]), encoding="utf-8")
            _, text = self.call("pdal", "pipeline", pipeline, "--validate")
            self.assertEqual(json.loads(text)["valid"], valid, text)


if __name__ == "__main__":
    unittest.main()
