"""Check that every word of the deck has a page in doc/manual and an example that runs.

    python tools/manual.py [--bezel build/release/bezel] [--out build/manual]

The words are those of `bezel --list commands` and of src/input/word_table.f90. The page of a word
is doc/manual/<KEY>.md, where KEY is its first four letters. Lines `Example:
[...](../../input/manual/<name>.inp)` of the page name examples, which must use the word and end
with code 0. A word whose page says that it is not available yet needs no example. The FEAP words in
src/deck/deck_feap.f90 must be those in doc/manual/feap.md, with the same texts, and none of them
may be a word of the deck. The exit code is 1 if anything is wrong.
"""

import argparse
import pathlib
import re
import resource
import subprocess
import sys

TOP = pathlib.Path(__file__).resolve().parent.parent
PAGES = TOP / "doc" / "manual"
OF_THE_STREAM = ["LOOP", "NEXT", "INCLude", "END"]  # words that are not in the table of mesh words
NOT_YET = "Not available yet"
LONGEST = 5.0  # CPU seconds that an example may take by default


def main(argv=None):
    """Check pages and examples; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bezel", type=pathlib.Path, default=TOP / "build/release/bezel")
    parser.add_argument("--out", type=pathlib.Path, default=TOP / "build/manual")
    parser.add_argument(
        "--longest", type=float, default=LONGEST, help="CPU seconds an example may take"
    )
    o = parser.parse_args(argv)
    keys = sorted(
        {word[:4].upper() for word in mesh_words() + command_words(o.bezel) + OF_THE_STREAM}
    )
    complaints = check_index(keys) + check_feap(
        mesh_words() + OF_THE_STREAM, command_words(o.bezel)
    )
    examples = {}
    for key in keys:
        complaints += check_page(key, examples)
    complaints += [
        f"{p.name}: the deck has no word to which this page belongs"
        for p in PAGES.glob("[A-Z]*.md")
        if p.stem not in keys
    ]
    o.out.mkdir(parents=True, exist_ok=True)
    for deck in sorted(
        set(examples.values()), key=lambda d: (d.stem == "rest", d)
    ):  # after save, whose checkpoint it needs
        complaints += run_example(o.bezel.resolve(), deck, o.out, o.longest)
    unused = set((TOP / "input/manual").glob("*.inp")) - set(examples.values())
    complaints += [
        f"input/manual/{deck.name}: no page links to this example" for deck in sorted(unused)
    ]
    print(
        "\n".join(
            [
                *complaints,
                f"{len(keys)} words, {len(set(examples.values()))} examples, {len(complaints)} complaints",
            ]
        )
    )
    return 1 if complaints else 0


def mesh_words():
    """The words in the table of mesh words."""
    return re.findall(r"call add\(table, '(\w+)'", (TOP / "src/input/word_table.f90").read_text())


def command_words(bezel):
    """The words in the table of commands, as the program lists them."""
    listing = subprocess.run(
        [bezel, "--list", "commands"], capture_output=True, text=True, check=True
    ).stdout
    return re.findall(r"^  (\w+)", listing, re.M)


def check_index(keys):
    """Complaints about words that the index of the manual does not link to."""
    linked = re.findall(r"\((\w+)\.md\)", (PAGES / "index.md").read_text())
    return [f"index.md: missing link to {key}.md" for key in keys if key not in linked]


def check_feap(mesh, commands):
    """Complaints about words of FEAP: the hints of the program and the manual's page must agree."""
    source = (TOP / "src/deck/deck_feap.f90").read_text()
    tables = source.split("type(advice_t), parameter ::")[1:]
    hinted = [feap_hints(table) for table in tables]
    page = (PAGES / "feap.md").read_text().split("\n## ")
    listed = [
        {
            word[:4].lower(): text
            for word, text in re.findall(r"^\| `(\w+)` \| (.*) \|$", part, re.M)
        }
        for part in page[1:4]
    ]
    complaints = [
        f"feap.md and deck_feap.f90: '{key}' is only in one of them"
        for here, there in zip(hinted, listed, strict=True)
        for key in sorted(set(here) ^ set(there))
    ]
    complaints += [
        f"feap.md: the text of '{key}' is not the hint of the program: {here[key]}"
        for here, there in zip(hinted, listed)
        for key in here
        if there.get(key, here[key]) != here[key]
    ]
    for known, keys in zip((mesh, commands), hinted):
        ours = {word[:4].lower() for word in known}
        complaints += [
            f"deck_feap.f90: '{key}' is also a word of the deck" for key in keys if key in ours
        ]
    return complaints


def feap_hints(table):
    """The hints of one table of deck_feap.f90 as sentences, by the first four letters of words."""
    hints = {}
    row = r"advice_t\('([^']*)',((?:\s|&|//|'(?:[^']|'')*')+)\)"
    for words, literals in re.findall(row, table):
        text = "".join(re.findall(r"'((?:[^']|'')*)'", literals)).replace("''", "'")
        sentence = text if text.startswith("bezel") else text[0].upper() + text[1:]
        hints.update(dict.fromkeys(words.split(), sentence + "."))
    return hints


def check_page(key, examples):
    """Complaints about a page; its examples are added to `examples`."""
    page = PAGES / f"{key}.md"
    if not page.exists():
        return [f"{key}: missing page doc/manual/{key}.md"]
    text = page.read_text()
    complaints = [
        f"{page.name}: link to {link}, which does not exist"
        for link in re.findall(r"\]\(([^)#:]+)\)", text)
        if not (PAGES / link).exists()
    ]
    names = re.findall(r"^Example: .*\(../../(input/manual/\w+\.inp)\)", text, re.M)
    if not names and NOT_YET not in text:
        complaints.append(f"{page.name}: missing example")
    for name in names:
        deck = TOP / name
        if not deck.exists():
            continue
        examples[key, name] = deck
        if not re.search(rf"^\s*{key}", deck.read_text(), re.M | re.I):
            complaints.append(f"{name}: does not use {key}")
    return complaints


def run_example(bezel, deck, out, longest):
    """Complaints about the run of an example."""
    start = cpu_of_children()
    run = subprocess.run([bezel, "--quiet", deck], cwd=out, capture_output=True, text=True)
    seconds = cpu_of_children() - start
    name = deck.relative_to(TOP)
    if run.returncode != 0:
        return [f"{name}: ended with code {run.returncode}\n{run.stderr.strip()}"]
    return (
        [f"{name}: expected at most {longest:g} CPU seconds, took {seconds:.1f}"]
        if seconds > longest
        else []
    )


def cpu_of_children():
    """CPU seconds of all programs run so far, which do not depend on the load of the machine."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    sys.exit(main())
