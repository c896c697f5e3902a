"""The only exception of this package."""


class Unreadable(Exception):
    """A file or an option cannot be used; the text is one sentence for the user.

    >>> raise Unreadable("'a.dat' does not exist")
    Traceback (most recent call last):
    post._error.Unreadable: 'a.dat' does not exist
    """
