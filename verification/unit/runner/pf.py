"""Translate unit tests from pFUnit's language (.pf) to Fortran.

usage: pf.py test IN.pf OUT.f90         one module of tests
       pf.py join IN.pf OUT.pf          each assertion on one line, as pFUnit's own translator requires
       pf.py driver OUT.f90 IN.pf ...   the program that runs all tests

The subset consists of @test, @before and @after on a line of their own before a subroutine without
arguments, and of the assertions of funit.f90. Line numbers are preserved, so the compiler's
messages point into the .pf file.
"""

import re
import sys
from pathlib import Path

RELATIONS = {
    "equal": "equal",
    "notequal": "other than",
    "lessthan": "<",
    "lessthanorequal": "<=",
    "greaterthan": ">",
    "greaterthanorequal": ">=",
}
ASSERTIONS = {
    word.lower(): word
    for word in """True False Equal NotEqual LessThan LessThanOrEqual GreaterThan GreaterThanOrEqual
    Any All None IsNaN IsFinite Fail""".split()
}
LONGEST_NAME = 63  # Fortran's
MARKS = ("test", "before", "after")


class BadTest(Exception):
    """The file goes beyond the subset; the text says where and why."""


def without_comment(line):
    """The part of a line before a `!` that is not inside quotes."""
    quote = ""
    for i, char in enumerate(line):
        if quote:
            quote = "" if char == quote else quote
        elif char in "'\"":
            quote = char
        elif char == "!":
            return line[:i].rstrip()
    return line.rstrip()


def joined(path):
    """(number, text) of each line; an assertion continued with & is joined into its first line."""
    lines = path.read_text().splitlines()
    i = 0
    while i < len(lines):
        number, text = i + 1, lines[i]
        if re.match(r"\s*@assert", text, re.I):
            text = without_comment(text)
            while text.endswith("&") and i + 1 < len(lines):
                i += 1
                text = (
                    text[:-1].rstrip()
                    + " "
                    + without_comment(lines[i]).strip().removeprefix("&").lstrip()
                )
        yield number, text
        i += 1


def tests_of(path):
    """The name of the module, and its subroutines marked @test, @before and @after."""
    module, mark, marked = "", "", {"test": [], "before": [], "after": []}
    for number, text in joined(path):
        code = without_comment(text).strip()
        if match := re.fullmatch(r"module\s+(\w+)", code, re.I):
            module = match[1].lower()
        elif match := re.fullmatch(r"@(test|before|after)", code, re.I):
            mark = match[1].lower()
        elif match := re.fullmatch(r"subroutine\s+(\w+)\s*(\(\s*\))?", code, re.I):
            if mark:
                marked[mark].append(match[1])
            if len(match[1]) > LONGEST_NAME:
                raise BadTest(f"{path}:{number}: {match[1]} has more than {LONGEST_NAME} letters")
            mark = ""
        elif code and mark:
            raise BadTest(
                f"{path}:{number}: @{mark} must stand before a subroutine without arguments"
            )
    if module != path.stem.lower():
        raise BadTest(f"{path}:1: the module must be named {path.stem}, after the file")
    if not marked["test"]:
        raise BadTest(f"{path}:1: no @test in the file")
    return module, marked


def compact(arguments):
    """The arguments with the two values in parentheses, which make a copy of an array section:
    gfortran 12 loses the stride of a section such as list%n when it is passed as `class(*)`.

    >>> compact("[1, 2], list(:)%n, 'one, two'")
    "([1, 2]), (list(:)%n), 'one, two'"
    """
    parts, depth, quote = [""], 0, ""
    for char in arguments:
        if quote:
            quote = "" if char == quote else quote
        elif char in "'\"":
            quote = char
        elif char in "([":
            depth += 1
        elif char in ")]":
            depth -= 1
        if char == "," and depth == 0 and not quote:
            parts.append("")
        else:
            parts[-1] += char
    return ",".join(
        f"{' ' * (i > 0)}({part.strip()})" if i < 2 else part for i, part in enumerate(parts)
    )


def translate(path):
    """The Fortran text of a .pf file."""
    tests_of(path)
    out, expected = [], 1
    for number, text in joined(path):
        if number != expected:
            out.append(f'# {number} "{path}"')
        expected = number + 1
        stripped = text.strip()
        if not stripped.startswith("@"):
            out.append(text)
            continue
        word = re.match(r"@(\w*)", stripped)[1].lower()
        if word in MARKS:
            out.append("")
            continue
        match = re.fullmatch(r"@assert(\w+)\s*\((.*)\)", stripped, re.I)
        if not match or match[1].lower() not in ASSERTIONS:
            known = " ".join(ASSERTIONS.values())
            raise BadTest(
                f"{path}:{number}: '{stripped}' is not an assertion on a line of its own; known: @assert + {known}"
            )
        comma = ", " if match[2].strip() else ""
        relation = RELATIONS.get(match[1].lower())
        name = f"That('{relation}', " if relation else f"{match[1]}("
        values = compact(match[2]) if relation else match[2]
        out.append(f"call assert{name}{values}{comma}&")
        out.append(f"  location=SourceLocation('{path}', {number})); if (anyExceptions()) return")
        expected = -1
    return f'# 1 "{path}"\n' + "\n".join(out) + "\n"


def driver(paths):
    """The text of the program that runs every test of every file through run_test of module
    funit.
    """
    out = [
        "program run_unit_tests",
        "  use funit, only: start_tests, run_test, stop_tests, no_fixture",
        "  implicit none",
        "",
        "  call start_tests()",
    ]
    for path in paths:
        module, marked = tests_of(path)
        before, after = (marked[m][0] if marked[m] else "no_fixture" for m in ("before", "after"))
        names = ", ".join(sorted({*marked["test"], *marked["before"], *marked["after"]}))
        out += ["  block", f"    use {module}, only: {names}"]
        out += [
            f"    call run_test('{path}', '{name}', {name}, {before}, {after})"
            for name in marked["test"]
        ]
        out += ["  end block"]
    return "\n".join([*out, "  call stop_tests()", "end program run_unit_tests"]) + "\n"


def main(arguments):
    match arguments:
        case ["test", source, target]:
            text = translate(Path(source))
        case ["join", source, target]:
            lines = dict(joined(Path(source)))
            text = "".join(lines.get(n, "") + "\n" for n in range(1, max(lines) + 1))
        case ["driver", target, *sources]:
            text = driver([Path(source) for source in sources])
        case _:
            sys.exit(__doc__)
    Path(target).write_text(text)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except BadTest as error:
        sys.exit(str(error))
