"""The smallest text that still fails: delta debugging on lines, then on words (Zeller and
Hildebrandt 2002).
"""

import time


def ddmin(parts, fails, until):
    """A list that fails, but no longer fails if any single item is removed; if the time is over
    earlier, the shortest list found so far.
    """
    n = 2
    while len(parts) >= 2 and time.monotonic() < until:
        size = max(1, len(parts) // n)
        for start in range(0, len(parts), size):
            rest = parts[:start] + parts[start + size :]
            if time.monotonic() >= until:
                return parts
            if rest and fails(rest):
                parts, n = rest, max(n - 1, 2)
                break
        else:
            if size == 1:
                return parts
            n = min(2 * n, len(parts))
    return parts


def minimise(data, fails, seconds=40):
    """The shortest bytes found within some seconds for which fails(bytes) is true."""
    until = time.monotonic() + seconds
    lines = ddmin(data.split(b"\n"), lambda part: fails(b"\n".join(part)), until)
    for i in range(len(lines)):
        around = lines[:i], lines[i + 1 :]
        whole = lambda part, around=around: b"\n".join([*around[0], b" ".join(part), *around[1]])
        words = ddmin(lines[i].split(b" "), lambda part, whole=whole: fails(whole(part)), until)
        lines[i] = b" ".join(words)
    return b"\n".join(lines)
