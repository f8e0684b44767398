"""The page to look at a model in."""

from __future__ import annotations

import html
import os
import pathlib
import webbrowser


class Page:
    """A page of ``gable view``: a file, and in Jupyter what the cell shows."""

    #: Height of the frame in a notebook, pixels.
    HEIGHT = 600

    def __init__(self, path: str, keeps: object = None) -> None:
        #: The HTML file.
        self.path = pathlib.Path(path)
        # The folder of the file, which must not go before the page does.
        self._keeps = keeps

    def open(self) -> None:
        """Opens the page in a browser."""
        webbrowser.open(self.path.absolute().as_uri())

    def __fspath__(self) -> str:
        return os.fspath(self.path)

    def _repr_html_(self) -> str:
        source = html.escape(self.path.read_text(encoding="utf-8"), quote=True)
        style = f"width: 100%; height: {self.HEIGHT}px; border: 0"
        return f'<iframe srcdoc="{source}" style="{style}" allow="fullscreen"></iframe>'

    def __repr__(self) -> str:
        return f"<gable.Page: {self.path}; open() shows it in a browser>"
