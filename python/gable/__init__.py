"""Airborne laser tiles and building footprints in, valid LoD 2 city models out.

>>> import gable
>>> model = gable.reconstruct("tiles/", "buildings.gpkg")  # doctest: +SKIP
>>> model.save("city.city.json")  # doctest: +SKIP
>>> model.to_geopandas().explore("gable_rmse_lod22")  # doctest: +SKIP

Names and options are those of the command line. What goes wrong is a :class:`GableError` with the same text; what stops
nothing is a :class:`GableWarning`. While gable works, other threads of Python go on, and Ctrl-C is heeded.
"""

from ._calls import Pipeline, convert, evaluate, pipeline, read, reconstruct, validate
from ._gable import VERSION as __version__
from ._mesh import Mesh
from ._model import Building, Model
from ._page import Page
from ._report import Evaluation, Report, Validation
from .errors import FileError, GableError, GableWarning, InputError

__all__ = [
    "Building",
    "Evaluation",
    "FileError",
    "GableError",
    "GableWarning",
    "InputError",
    "Mesh",
    "Model",
    "Page",
    "Pipeline",
    "Report",
    "Validation",
    "__version__",
    "convert",
    "evaluate",
    "pipeline",
    "read",
    "reconstruct",
    "validate",
]
