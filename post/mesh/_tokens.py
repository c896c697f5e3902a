"""Words of a text file, with errors that name what was expected."""

import pathlib

import numpy as np

from post._error import Unreadable


class Tokens:
    """The words of a file in order; `what` in the calls is the name of the expected item for
    messages.
    """

    def __init__(self, path, comment=None):
        self.path = str(path)
        lines = text_of(path).splitlines()
        if comment:
            lines = [line.split(comment, 1)[0] for line in lines]
        self.lines = lines
        self.words = " ".join(lines).split()
        self.at = 0

    def more(self):
        """Whether there are more words."""
        return self.at < len(self.words)

    def fail(self, text):
        """Raise Unreadable with the name of the file in front of the message."""
        raise Unreadable(f"'{self.path}': {text}")

    def left_in_line(self):
        """Number of words from the next one to the end of its line."""
        end = 0
        for line in self.lines:
            end += len(line.split())
            if end > self.at:
                break
        return end - self.at

    def word(self, what):
        """The next word."""
        if not self.more():
            self.fail(f"expected {what}, found the end of the file")
        self.at += 1
        return self.words[self.at - 1]

    def seek(self, *names):
        """Skip to one of these words (upper case) and return it, or None at the end of the file."""
        while self.more():
            word = self.word("a keyword").upper()
            if word in names:
                return word
        return None

    def integer(self, what):
        """The next word as an integer."""
        return int(self.numbers(1, what, int)[0])

    def count(self, what):
        """The next word as a count, which must be neither negative nor larger than the number of
        words in the file.
        """
        n = self.integer(what)
        if not 0 <= n <= len(self.words):
            self.fail(f"{n} is not a valid value of {what}")
        return n

    def numbers(self, n, what, kind=float):
        """(n) the next words as numbers, which must be finite."""
        words = self.words[self.at : self.at + n]
        one = what if n == 1 else f"a number of {what}"
        if len(words) < n:
            after = "" if n == 1 else f" after {len(words)} of {n}"
            self.fail(f"expected {one}, found the end of the file{after}")
        try:
            values = np.array(words, dtype=float)
        except ValueError:
            bad = next(w for w in words if not _is_number(w))
            self.fail(f"expected {one}, found '{bad}'")
        if not np.isfinite(values).all():
            self.fail(f"{one} is not finite")
        if kind is int:
            if (values != np.rint(values)).any() or (abs(values) > 2**52).any():
                self.fail(f"{one} is not an integer")
            values = values.astype(np.int64)
        self.at += n
        return values


def text_of(path):
    """The text of a file; raise Unreadable if it cannot be read or is binary."""
    try:
        data = pathlib.Path(path).read_bytes()
    except OSError as error:
        raise Unreadable(f"'{path}' cannot be read: {error.strerror}") from None
    try:
        return data.decode("utf-8-sig")  # some editors write a byte-order mark
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
