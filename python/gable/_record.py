"""What gable has to tell, as read-only dictionaries and as tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas


class Table(Sequence[dict[str, Any]]):
    """Rows, each a dict; a DataFrame when it is asked for."""

    def __init__(self, rows: list[dict[str, Any]], index: str | None = None) -> None:
        self._rows = rows
        self._index = index

    def __getitem__(self, place: Any) -> Any:
        return self._rows[place]

    def __len__(self) -> int:
        return len(self._rows)

    def __repr__(self) -> str:
        return f"<{len(self)} rows; to_frame() makes a DataFrame of them>"

    def to_frame(self) -> pandas.DataFrame:
        """A ``pandas.DataFrame``; what is nested has columns of its own, such as ``completeness_missing``."""
        try:
            import pandas
        except ImportError:
            raise ImportError("to_frame() needs pandas: pip install pandas") from None
        frame = pandas.json_normalize(self._rows, sep="_")
        return frame.set_index(self._index) if self._index in frame.columns else frame


class Record(Mapping[str, Any]):
    """JSON that gable wrote: a read-only dict, its members also as attributes."""

    def __init__(self, members: dict[str, Any]) -> None:
        self._members = members

    def __getitem__(self, name: str) -> Any:
        return self._members[name]

    def __getattr__(self, name: str) -> Any:
        try:
            return self.__dict__["_members"][name]
        except KeyError:
            raise AttributeError(f"{type(self).__name__} has no {name!r}: it has {', '.join(self)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._members)

    def __len__(self) -> int:
        return len(self._members)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._members]

    def to_dict(self) -> dict[str, Any]:
        """The JSON as it is."""
        return self._members
