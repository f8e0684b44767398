"""PDAL and gable, and what comes of the same pipeline in both."""

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
DATA = ROOT / "examples" / "data"
TILE = str(DATA / "delft_ahn3.laz")
FOOTPRINTS = str(DATA / "footprints.geojson")
PROGRAMS = {"pdal": os.environ["PDAL"], "gable": os.environ["GABLE"]}
SECONDS = 300


class Both(unittest.TestCase):
    """Cases with a folder of their own, in which both programs run the same pipelines."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="gable-pdal-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def call(self, program, *arguments):
        """Runs one of them; gives its exit code, and what it printed."""
        command = [PROGRAMS[program], *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
        return done.returncode, done.stdout + done.stderr

    def run_pipeline(self, program, stages, code=0):
        """Runs a pipeline whose files are named after the program where they have `{}` in them; gives what it printed and
        the metadata of its stages."""
        # What has no other name is called after the pipeline there, and "points" in the plugin.
        (self.folder / program).mkdir(exist_ok=True)
        pipeline, metadata = (self.folder / program / name for name in ("points.json", "metadata.json"))
        pipeline.write_text(json.dumps(stages).replace("{}", f"{self.folder}/{program}"), encoding="utf-8")
        got, text = self.call(program, "pipeline", pipeline, "--metadata", metadata)
        self.assertEqual(got != 0, code != 0, f"{program} gives {got}: {text}")
        told = json.loads(metadata.read_text(encoding="utf-8"))["stages"] if metadata.exists() else {}
        return text, told

    def both(self, stages, code=0):
        """Runs it in both, PDAL first."""
        return [self.run_pipeline(program, stages, code) for program in PROGRAMS]

    def same_bytes(self, name):
        """Both have written the same file, which is not empty."""
        ours, theirs = ((self.folder / f"{program}{name}").read_bytes() for program in ("gable", "pdal"))
        self.assertGreater(len(ours), 0)
        if ours != theirs:
            place = next((i for i, (a, b) in enumerate(zip(ours, theirs)) if a != b), min(len(ours), len(theirs)))
            around = slice(max(0, place - 60), place + 60)
            self.fail(f"{name} differs at byte {place}: PDAL {theirs[around]!r}, gable {ours[around]!r}")
