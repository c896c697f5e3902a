"""Write tables into pages of doc/verification."""

import re


def put_table(text, name, table):
    """The text with a new table between the marks of this name.

    >>> put_table("<!-- table: a -->old<!-- end -->", "a", "new")
    '<!-- table: a -->\\nnew\\n<!-- end -->'
    """
    mark = f"<!-- table: {name} -->"
    return re.sub(
        f"{mark}.*?<!-- end -->", lambda _: f"{mark}\n{table}\n<!-- end -->", text, flags=re.S
    )
