"""The report of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._record import Record, Table

if TYPE_CHECKING:
    import pandas


class Report(Record):
    """What came in, what became of each building and why, how good it is and what it cost.

    The members are those of ``schemas/report.schema.json``, as items and as attributes:

    >>> report.counts["buildings_lod22"]  # doctest: +SKIP
    70
    >>> report.buildings.to_frame().rmse_lod22.describe()  # doctest: +SKIP
    """

    def __init__(self, members: dict[str, Any], summary: str = "") -> None:
        super().__init__(members)
        self._summary = summary

    @property
    def buildings(self) -> Table:
        """What became of each building, in the order of the footprints."""
        return Table(self._members["buildings"], "id")

    def to_frame(self) -> pandas.DataFrame:
        """The buildings as a ``pandas.DataFrame`` by id."""
        return self.buildings.to_frame()

    def __str__(self) -> str:
        return self._summary or repr(self)

    def __repr__(self) -> str:
        counts = self._members["counts"]
        return f"<gable.Report: {counts['footprints']} footprints, {counts['buildings_lod22']} buildings at LoD 2.2>"


class Validation(Record):
    """The findings on a model, in the shape of val3dity's report; true if it is valid."""

    @property
    def valid(self) -> bool:
        """Whether nothing is invalid."""
        return bool(self._members["validity"])

    @property
    def findings(self) -> Table:
        """Every fault with its place. What labels and attributes say that is not so (801 to 808) does not make a model
        invalid."""
        of_file = self._members["dataset_errors"] + self._members["schema_errors"]
        rows = [{"feature": "", **fault} for fault in of_file]
        for feature in self._members["features"]:
            faults = feature["errors"] + feature["semantic_errors"]
            rows += [{"feature": feature["id"], **fault} for fault in faults]
        return Table(rows)

    def to_frame(self) -> pandas.DataFrame:
        """The findings as a ``pandas.DataFrame``."""
        return self.findings.to_frame()

    def __bool__(self) -> bool:
        return self.valid

    def __repr__(self) -> str:
        return f"<gable.Validation: {'valid' if self.valid else 'INVALID'}, {len(self.findings)} findings>"


class Evaluation(Record):
    """How good a model is: ``overall`` figures, and those of each of its ``buildings``."""

    @property
    def buildings(self) -> Table:
        """The figures building by building."""
        return Table(self._members["buildings"], "id")

    def to_frame(self) -> pandas.DataFrame:
        """The buildings as a ``pandas.DataFrame`` by id."""
        return self.buildings.to_frame()

    def __repr__(self) -> str:
        return f"<gable.Evaluation: {len(self.buildings)} buildings>"
