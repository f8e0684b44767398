"""What can go wrong, as exceptions with the text of the command line."""

from __future__ import annotations

__all__ = ["FileError", "GableError", "GableWarning", "InputError"]


class GableError(Exception):
    """What stops a call. Catch this for all of them."""


class InputError(GableError, ValueError):
    """A file or an option that is not what it should be."""

    def __init__(
        self, text: str, file: str = "", place: str = "", found: str = "", expected: str = "", remedy: str = ""
    ) -> None:
        super().__init__(text)
        #: The file or option at fault.
        self.file = file
        #: Where in it: a feature, a byte, an option. Empty when it is the file as a whole.
        self.place = place
        #: What was found there.
        self.found = found
        #: What was expected.
        self.expected = expected
        #: What can be done about it; may be empty.
        self.remedy = remedy

    @classmethod
    def of(cls, file: str, found: str, expected: str, *, place: str = "", remedy: str = "") -> InputError:
        """The error with its text made of its parts, as gable does."""
        text = f"{file}{', ' + place if place else ''}: found {found}, expected {expected}"
        return cls(f"{text}. {remedy}" if remedy else text, file, place, found, expected, remedy)


class FileError(GableError, OSError):
    """What the system refused to read or write."""

    def __init__(self, text: str, errno: int | None = None, filename: str | None = None) -> None:
        super().__init__(text)
        self.errno = errno
        self.filename = filename

    def __str__(self) -> str:
        return str(self.args[0])


class GableWarning(UserWarning):
    """Something that one should know and that stops nothing; the command line prints it as ``warning: …``."""
