"""Mutations of decks, of the files they read, and of checkpoints."""

import re

import numpy as np

from verification.mutate import JUNK, mutate

EXTREMES = (
    "0 -1 1 -0 0.0 1e308 -1e308 1e309 1e-300 1e-320 nan inf -inf 2147483647 2147483648 -2147483648 "
    "99999999999999999999 4294967297 1e9 100000000 0x10 1d3 1.e 1e 1.2.3 + - . 007"
).split()
SELF = "itself.inc"  # stands for the name of the mutated file
NAMES = ("é💥ß", "\u202e", "a" * 300, "a" * 70000, '"a b"', "a/b", "../x", "%s%n", "$(x)", "-o")
WORD = re.compile(r"[^\s,=]+")
NUMBER = re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)([eEdD][-+]?\d+)?$")


def words_of(lines):
    """Where words are: [(line, match)]."""
    return [(i, match) for i, line in enumerate(lines) for match in WORD.finditer(line)]


def put(lines, place, text):
    i, match = place
    lines[i] = lines[i][: match.start()] + text + lines[i][match.end() :]
    return lines


def extreme_number(lines, chance):
    """Replace a number by an extreme one."""
    places = [p for p in words_of(lines) if NUMBER.match(p[1][0])]
    return put(lines, chance.choice(places), chance.choice(EXTREMES)) if places else lines


def swap_words(lines, chance):
    """Exchange two words."""
    places = words_of(lines)
    if len(places) < 2:
        return lines
    a, b = chance.sample(places, 2)
    if a[0] == b[0] and a[1].start() > b[1].start():
        a, b = b, a
    one, other = a[1][0], b[1][0]
    lines = put(lines, b, one)
    return put(lines, a, other)


def repeat_word(lines, chance):
    places = words_of(lines)
    return put(lines, p := chance.choice(places), f"{p[1][0]} {p[1][0]}") if places else lines


def drop_word(lines, chance):
    places = words_of(lines)
    return put(lines, chance.choice(places), "") if places else lines


def strange_word(lines, chance):
    """A long name, a name that is not ASCII, a path or junk."""
    places = words_of(lines)
    return put(lines, chance.choice(places), chance.choice((*NAMES, *JUNK))) if places else lines


def other_word(lines, chance):
    """Insert another word of the same file, so that the grammar is almost right."""
    places = words_of(lines)
    return put(lines, chance.choice(places), chance.choice(places)[1][0]) if places else lines


def move_block(lines, chance):
    """Move or repeat a block of records that belong together."""
    if len(lines) < 4:
        return lines
    a = chance.randrange(len(lines) - 2)
    block = lines[a : a + chance.randint(1, 12)]
    if chance.random() < 0.5:
        lines = lines[:a] + lines[a + len(block) :]
    at = chance.randrange(len(lines) + 1)
    return lines[:at] + block + lines[at:]


def line_ends(lines, chance):
    """Change the line ends or separators: CR LF, CR, tabs, trailing blanks, a byte order mark."""
    what = chance.randrange(5)
    if what == 0:
        return [line + "\r" for line in lines]
    if what == 1:
        at = chance.randrange(len(lines))
        lines[at] = lines[at].replace(" ", "\r")
        return lines
    if what == 2:
        return [line.replace("  ", "\t") for line in lines]
    if what == 3:
        return [line + "   \t" for line in lines]
    return ["\ufeff" + lines[0], *lines[1:]] if lines else lines


def include(lines, chance):
    """Make the deck include itself, a folder, a missing file, or a device."""
    what = chance.choice((SELF, SELF, ".", "missing.inc", "/dev/zero", "/dev/null", "", "a" * 5000))
    lines.insert(chance.randrange(len(lines) + 1), f"INCLude {what}")
    return lines


def continue_line(lines, chance):
    at = chance.randrange(len(lines))
    lines[at] += " &"
    return lines


GRAMMAR = (
    extreme_number,
    extreme_number,
    extreme_number,
    swap_words,
    repeat_word,
    drop_word,
    strange_word,
    other_word,
    other_word,
    move_block,
    line_ends,
    include,
    continue_line,
)


def mutate_bytes(data, chance):
    """Flip bits, and cut, repeat or insert bytes."""
    data = bytearray(data)
    for _ in range(chance.randint(1, 6)):
        at = chance.randrange(len(data) + 1)
        what = chance.randrange(6)
        if what < 3 and at < len(data):
            data[at] ^= 1 << chance.randrange(8)
        elif what == 3:
            del data[at : at + chance.randint(1, 40)]
        elif what == 4:
            data[at:at] = data[at : at + chance.randint(1, 200)]
        else:
            data[at:at] = bytes(chance.randrange(256) for _ in range(chance.randint(1, 8)))
    if chance.random() < 0.05:
        del data[chance.randrange(len(data) + 1) :]
    return bytes(data)


def mutate_text(data, chance, name="", includes=True):
    """Make one mutation of the file `name`, given and returned as bytes: according to its grammar,
    by junk, or of single bytes; includes: whether the file may contain records of a deck.
    """
    kind = chance.random()
    if kind < 0.15:
        return mutate_bytes(data, chance)
    text = data.decode(errors="surrogateescape")
    if kind < 0.45:
        return mutate(text, chance).encode(errors="surrogateescape")
    lines = text.split("\n")
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        change = chance.choice(GRAMMAR)
        if change is include and not includes:
            change = extreme_number
        lines = change(lines, chance)
    return "\n".join(lines).replace(SELF, name).encode(errors="surrogateescape")


def mutate_checkpoint(path, chance):
    """Damage a checkpoint in place; return how."""
    if chance.random() < 0.4:
        data = bytearray(path.read_bytes())
        what = chance.randrange(4)
        at = chance.randrange(len(data))
        if what == 0:
            data[at] ^= 1 << chance.randrange(8)
        elif what == 1:
            del data[at:]
        elif what == 2:
            data[at : at + chance.randint(1, 64)] = b""
        else:
            data[at : at + chance.randint(1, 4096)] = bytes(chance.randint(1, 4096))
        path.write_bytes(data)
        return f"bytes at {at} ({('flipped', 'cut', 'removed', 'zeroed')[what]})"
    import h5py

    with h5py.File(path, "r+") as file:
        names = []
        file.visititems(lambda name, item: names.append(name))
        name = chance.choice(sorted(names))
        what = chance.randrange(5)
        item = file[name]
        if what == 0:
            del file[name]
            return f"{name} deleted"
        if what == 1 and len(file.attrs):
            key = chance.choice(sorted(file.attrs))
            value = chance.choice((0, -1, 2**31 - 1, "x", 1e308))
            file.attrs[key] = value
            return f"attribute {key} = {value}"
        if isinstance(item, h5py.Group):
            other = chance.choice(sorted(names))
            file[f"{name}/extra"] = h5py.SoftLink(f"/{other}")
            return f"{name} links to {other}"
        values = item[...]
        if what == 2:
            attributes = dict(item.attrs)
            del file[name]
            shape = chance.choice(((0,), (1,), (7,), (3, 3), (100000,)))
            file[name] = np.zeros(shape, dtype=values.dtype)
            file[name].attrs.update(attributes)
            return f"{name} has shape {shape}"
        if what == 3:
            attributes = dict(item.attrs)
            del file[name]
            file[name] = b"text"
            file[name].attrs.update(attributes)
            return f"{name} is a text"
        if values.size == 0:
            del file[name]
            return f"{name} deleted"
        bad = (np.nan, np.inf, 1e308, 0.0) if values.dtype.kind == "f" else (0, 127, 1, 100)
        value = chance.choice(bad)
        values.flat[chance.randrange(values.size)] = value
        item[...] = values
        return f"{name} contains {value}"
