"""Words of a text file, with errors that say what was expected and where the file ended."""

import pathlib

import numpy as np

from post._error import Unreadable


class Tokens:
    """The words of a file, read from left to right; `what` in the calls is for the message."""

    def __init__(self, path, comment=None):
        self.path = str(path)
        lines = text_of(path).splitlines()
        if comment:
            lines = [line.split(comment, 1)[0] for line in lines]
        self.lines = lines
        self.words = " ".join(lines).split()
        self.at = 0

    def more(self):
        """Whether words are left."""
        return self.at < len(self.words)

    def fail(self, text):
        """Raise the package's exception with the file's name in front."""
        raise Unreadable(f"'{self.path}': {text}")

    def word(self, what):
        """The next word."""
        if not self.more():
            self.fail(f"the file ends where {what} should stand")
        self.at += 1
        return self.words[self.at - 1]

    def seek(self, *names):
        """Read on to one of these words (upper case) and return it; None where there is none."""
        while self.more():
            word = self.word("a keyword").upper()
            if word in names:
                return word
        return None

    def integer(self, what):
        """The next word as an integer."""
        return int(self.numbers(1, what, int)[0])

    def count(self, what):
        """The next word as a number of things: not negative, and no more than the file has words."""
        n = self.integer(what)
        if not 0 <= n <= len(self.words):
            self.fail(f"{n} as {what}")
        return n

    def numbers(self, n, what, kind=float):
        """(n) the next words as numbers, all of them finite."""
        words = self.words[self.at : self.at + n]
        if len(words) < n:
            self.fail(f"the file ends after {len(words)} of {n} numbers of {what}")
        try:
            values = np.array(words, dtype=float)
        except ValueError:
            bad = next(w for w in words if not _is_number(w))
            self.fail(f"'{bad}' stands where a number of {what} should")
        if not np.isfinite(values).all():
            self.fail(f"a number of {what} is not finite")
        if kind is int:
            if (values != np.rint(values)).any() or (abs(values) > 2**52).any():
                self.fail(f"a number of {what} is not an integer")
            values = values.astype(np.int64)
        self.at += n
        return values


def text_of(path):
    """The text of a file; Unreadable where it is none."""
    try:
        data = pathlib.Path(path).read_bytes()
    except OSError as error:
        raise Unreadable(f"'{path}' cannot be read ({error.strerror})") from None
    try:
        return data.decode("utf-8-sig")  # editors of Windows put a mark in front
    except UnicodeDecodeError:
        raise Unreadable(f"'{path}' is binary; save it as ASCII") from None


def _is_number(word):
    """
    >>> _is_number("1e3"), _is_number("x")
    (True, False)
    """
    try:
        float(word)
        return True
    except ValueError:
        return False
