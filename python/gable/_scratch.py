"""Folders that go when nobody needs them any more."""

from __future__ import annotations

import os
import shutil
import tempfile
import weakref


class Scratch:
    """A temporary folder, removed with this object or at the end of the process."""

    def __init__(self) -> None:
        self.path = tempfile.mkdtemp(prefix="gable-")
        weakref.finalize(self, shutil.rmtree, self.path, ignore_errors=True)

    def file(self, name: str) -> str:
        """A file in it."""
        return os.path.join(self.path, name)
