"""Grammar of decks for VS Code (TextMate), made from the words that the program and its manual
know.

usage: grammar.py [--bezel build/release/bezel] [--write]

Without --write, the committed grammar is checked: it must be the one that follows from the words,
and its patterns must mark every word when written in full, as its first four letters, and in lower
case. The exit code is 1 otherwise. The words are those that tools/manual.py checks and those of
records in doc/manual/*.md.
"""

import argparse
import json
import pathlib
import re
import sys

from manual import OF_THE_STREAM, PAGES, TOP, command_words, mesh_words

FILE = TOP / "tools/packages/vscode/syntaxes/bezel.tmLanguage.json"
ALONE = ["FEAP", "BATCh", "STOP", *OF_THE_STREAM]
FUNCTIONS = (
    "sqrt exp log abs int min max sin cos tan asin acos atan atan2 sind cosd tand asind acosd atand"
)


def main(argv=None):
    """Write or check the grammar; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bezel", type=pathlib.Path, default=TOP / "build/release/bezel")
    parser.add_argument("--write", action="store_true", help="write the grammar")
    o = parser.parse_args(argv)
    words = {
        "keyword.control.bezel": [*ALONE, *mesh_words(), *command_words(o.bezel)],
        "support.type.bezel": record_words(),
    }
    wanted = json.dumps(grammar(words), indent=2) + "\n"
    if o.write:
        FILE.write_text(wanted)
    text = FILE.read_text() if FILE.exists() else "{}"
    complaints = unmarked(json.loads(text), words)
    if text != wanted:
        complaints.append(f"{FILE.relative_to(TOP)} is out of date; run tools/grammar.py --write")
    number = sum(map(len, words.values()))
    print("\n".join([*complaints, f"{number} words in the grammar, {len(complaints)} complaints"]))
    return 1 if complaints else 0


def record_words():
    """The words of records, which pages write with capitals in the syntax, or as code in the
    text.
    """
    words = set()
    for page in PAGES.glob("[A-Z]*.md"):
        text = page.read_text()
        syntax = re.search(r"## Syntax\n\n```\n(.*?)```", text, re.S)
        code = " ".join([syntax[1], *re.findall(r"`([^`\n]+)`", text)])
        words |= set(re.findall(r"(?<![\w-])[A-Z]{3,}[a-z]*\b", code))
    return sorted(words)


def pattern(words):
    """A pattern for words: the first four letters of a word suffice; shorter words are given in
    full.
    """
    keys = sorted({word[:4].upper() for word in words})
    long = "|".join(key for key in keys if len(key) == 4)
    short = "|".join(key for key in keys if len(key) < 4)
    return rf"(?i)(?<![\w.$])(?:(?:{long})[A-Za-z0-9]*|(?:{short}))(?![\w.])"


def grammar(words):
    """The grammar as a dictionary."""
    first = r"(?:^|(?<=;))\s*"
    control, records = (pattern(w) for w in words.values())
    return {
        "name": "bezel deck",
        "scopeName": "source.bezel",
        "fileTypes": ["inp"],
        "patterns": [
            {"name": "comment.line.exclamation.bezel", "match": "!.*$"},
            {"name": "string.quoted.double.bezel", "match": '"[^"]*"'},
            {"name": "string.unquoted.title.bezel", "match": r"(?i)(?<=^feap)\s.*$"},
            {"name": "keyword.control.bezel", "match": control.replace("(?i)", "(?i)" + first, 1)},
            {"name": "support.type.bezel", "match": records},
            {"name": "support.function.bezel", "match": rf"(?i)\b(?:{'|'.join(FUNCTIONS.split())})(?=\()"},
            {"name": "constant.numeric.bezel", "match": r"(?<![\w.])[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?(?!\w)"},
            {"name": "variable.other.assignment.bezel", "match": r"\b[A-Za-z]\w*(?=\s*=)"},
            {"name": "keyword.operator.bezel", "match": r"[-+*/^=&]"},
        ],
    }  # fmt: skip


def unmarked(found, words):
    """Complaints about words that the patterns do not mark as a whole."""
    patterns = {p["name"]: p["match"] for p in found.get("patterns", [])}
    complaints = []
    for scope, list_of_words in words.items():
        for word in list_of_words:
            for text in {word, word[:4], word.lower(), word.upper()}:
                match = re.search(patterns.get(scope, "(?!)"), f"  {text},x 1")
                if not match or match[0].strip() != text:
                    complaints.append(f"the grammar does not mark '{text}' as {scope}")
    return complaints


if __name__ == "__main__":
    sys.exit(main())
