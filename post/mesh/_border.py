"""T-junctions where the enriched part meets the plain part, and which edges become straight there.

A line is the edge of a large element together with the corners that hang on it. If a plain face
contains a segment of a line, or a corner that hangs on the line, the whole line becomes straight and its
corners become plain: a corner that does not hang gets a function of its own, and one that hangs
follows its masters. If only an end of a line is plain, the edges of the small elements along the
line are computed again from the edge of the large element.
"""

from dataclasses import dataclass, field

import numpy as np

from post._error import Unreadable


@dataclass(eq=False)
class Line:
    """An edge of a large element and the corners on it; two lines are equal only if identical."""

    ends: tuple  # (corner, corner)
    at: dict = field(default_factory=dict)  # hanging corner: its parameter from 0 to 1

    def corners(self):
        """All corners, including the ends."""
        return {*self.ends, *self.at}

    def parameter(self, v):
        """The parameter of corner v."""
        return float(self.ends.index(v)) if v in self.ends else self.at[v]


def lines(hanging):
    """[Line] of {corner: (a, b, tau)}; a and b may themselves be hanging corners.

    >>> lines({5: (1, 2, 0.5), 6: (5, 2, 0.5)})
    [Line(ends=(1, 2), at={5: 0.5, 6: 0.75})]
    """
    part = {
        frozenset((end, h)): frozenset((a, b)) for h, (a, b, _) in hanging.items() for end in (a, b)
    }
    found = {}
    for h, (a, b, tau) in in_order(hanging):
        edge = frozenset((a, b))
        while edge in part:
            edge = part[edge]
        line = found.setdefault(edge, Line(tuple(sorted(edge))))
        line.at[h] = (1 - tau) * line.parameter(a) + tau * line.parameter(b)
    return list(found.values())


def in_order(hanging):
    """[(corner, (a, b, tau))], ordered so that masters precede the corners that hang on them.

    >>> in_order({6: (5, 2, 0.5), 5: (1, 2, 0.5)})
    [(5, (1, 2, 0.5)), (6, (5, 2, 0.5))]
    """
    left, result = dict(sorted(hanging.items())), []
    while left:
        ready = [h for h, (a, b, _) in left.items() if a not in left and b not in left]
        if not ready:
            raise Unreadable("T-junctions hang on one another in a circle")
        result += [(h, left.pop(h)) for h in ready]
    return result


def by_corner(all_lines):
    """{corner: [lines that contain it]}"""
    found = {}
    for line in all_lines:
        for v in line.corners():
            found.setdefault(v, []).append(line)
    return found


def edges(corners):
    """The edges of elements (m, 4), a set of frozensets."""
    rows = corners.tolist()
    return {frozenset(edge) for row in rows for edge in zip(row, row[1:] + row[:1])}


def users(corners, elements):
    """{corner: [those of the given elements that contain it]}"""
    found = {}
    for e in elements:
        for v in corners[e].tolist():
            found.setdefault(v, []).append(e)
    return found


def protected(corners, keep, all_lines):
    """(k) corners all of whose elements must be splines so that the elements in `keep` do not
    change.
    """
    near = set(corners[keep].ravel().tolist())
    near = near.union(*(x.ends for x in all_lines if len(near & x.corners()) > 1))
    of = by_corner(all_lines)
    done, todo = set(), {x for v in near for x in of.get(v, [])}
    while todo:
        line = todo.pop()
        done.add(line)
        near |= line.corners()
        todo |= {x for v in line.at for x in of[v]} - done
    return np.array(sorted(near), dtype=np.int64)


def flattened(corners, plain, border, all_lines):
    """The corners that the plain faces make plain, and the lines that they make straight."""
    touched = set(corners[plain].ravel().tolist())
    plain_edges = edges(corners[plain])
    flat, straight = set(border), set()
    while True:
        more = {
            x for x in all_lines
            if frozenset(x.ends) in plain_edges or touched & set(x.at) or flat & set(x.at)
        } - straight  # fmt: skip
        if not more:
            return flat, straight
        straight |= more
        flat = flat.union(*(x.corners() for x in more))


def combination(v, own, hanging):
    """{function: factor} that gives the value at a corner: its own function, or those of its
    masters.

    >>> combination(5, {1: "a", 2: "b"}, {5: (1, 2, 0.25)})
    {'a': 0.75, 'b': 0.25}
    """
    return {own[v]: 1.0} if v in own else from_masters(v, own, hanging)


def from_masters(v, own, hanging):
    """`combination` for a hanging corner, through its masters even if it has a function of its
    own.
    """
    a, b, tau = hanging[v]
    return combined([(1 - tau, combination(a, own, hanging)), (tau, combination(b, own, hanging))])


def combined(pairs):
    """The sum of factor times row over (factor, row) pairs.

    >>> combined([(0.5, {1: 1.0}), (0.5, {1: 1.0, 2: 1.0})])
    {1: 1.0, 2: 0.5}
    """
    total = {}
    for factor, row in pairs:
        for i, c in row.items() if factor else ():
            total[i] = total.get(i, 0.0) + factor * c
    return total


def restricted(rows, start, end):
    """The Bezier points, as {function: factor}, of a curve between the parameters `start` and `end`.

    >>> restricted([{0: 1.0}, {1: 1.0}], 0.5, 1.0)
    [{0: 0.5, 1: 0.5}, {1: 1.0}]
    """
    p = len(rows) - 1
    result = []
    for j in range(p + 1):
        part = rows
        for t in (p - j) * [start] + j * [end]:
            part = [combined([(1 - t, a), (t, b)]) for a, b in zip(part[:-1], part[1:])]
        result.append(part[0])
    return result


def bent(flat, straight, all_lines):
    """Lines that are not straight but have a changed end, in the order in which to recompute
    them.
    """
    changed, left = set(flat), set()
    while True:
        more = {x for x in all_lines if changed & set(x.ends)} - straight - left
        if not more:
            break
        left |= more
        changed = changed.union(*(x.at for x in more))
    ordered = []
    while left:
        waits = set().union(*(x.at for x in left))
        ready = {x for x in left if not waits & set(x.ends)}
        if not ready:
            raise Unreadable(
                "T-junctions form a circle at the boundary of the enriched part; choose a larger or "
                "smaller part"
            )
        ordered += ready
        left -= ready
    return ordered
