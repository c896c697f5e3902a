"""The kinds of trials. Each is a function of a context and a generator of random numbers; it
returns the exit code of the run that counts, and a Failure or None.

To have a deck killed, stopped and run in other units, add an entry for it to KILLED.
"""

import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import tempfile
import threading
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from verification import TOP
from verification.recover import datasets, difference
from verification.soak.fuzz import EXTREMES, NAMES, mutate_checkpoint, mutate_text
from verification.soak.launch import call, check_curve, inputs_of, judge
from verification.soak.minimise import minimise

HERE = Path(__file__).resolve().parent
SMALL = HERE / "decks"

#: Decks that are killed and stopped, with the units of the quantities of their curve `force` as
#: powers of length, stress and time. They have the parameters l, s and t, and save every step.
KILLED = {
    SMALL / "friction.inp": ((2, 1, 0), (2, 1, 0), (2, 1, 0), (1, 0, 0)),
    SMALL / "cohesive.inp": ((1, 0, 0), (2, 1, 0), (0, 0, 0)),
    SMALL / "dynamic.inp": ((1, 0, 0), (2, 1, 0)),
    SMALL / "length.inp": ((1, 0, 0), (2, 1, 0)),
    SMALL / "self.inp": ((2, 1, 0), (2, 1, 0), (2, 0, 0), (1, 0, 0), (0, 0, 0)),
}
STOPS = (
    signal.SIGTERM,
    signal.SIGHUP,
    signal.SIGUSR1,
    signal.SIGUSR2,
    signal.SIGINT,
    signal.SIGXCPU,
)
STOPPED = 4
LIMIT = ("--time-limit", "3")  # a mutated deck may describe a long run, which must obey its limit
ROOM = ((resource.RLIMIT_AS, 3 * 2**30),)  # or a large one, which must fit or end with code 3
EQUAL = 1e-9  # difference of curves in other units, relative to the largest value of a column
EARLY = 0.03  # seconds during which a deck is still being read

OPTIONS = "--set --name --threads --time-limit --restart --check --list --quiet --x -q".split()
MESHES = (".msh", ".inc", ".txt")
SPLINES = (".iga", ".bxt", ".json", ".xml", ".layer", ".txt")


@dataclass
class Failure:
    what: str
    files: dict = field(default_factory=dict)  # {name: bytes} of the files that reproduce it
    how: str = ""  # arguments of the program


class Context:
    """The program under test, a temporary folder, and the runs that many trials need."""

    def __init__(self, bezel, top, slow=1.0):
        self.bezel, self.top, self.slow = bezel, Path(top), slow
        self.lock, self.known = threading.Lock(), {}
        manual = [d for d in sorted((TOP / "input").rglob("*.inp")) if d.stem not in ("rocker", "peel_test", "rest")]  # fmt: skip
        bad = sorted((TOP / "verification/deck_errors").glob("*.inp"))
        patches = [
            d for part in ("spline", "mesh_files", "rational", "distorted")
            for d in sorted((TOP / "verification/patch" / part).glob("*.inp"))
        ]  # fmt: skip
        silent = [*sorted(SMALL.glob("*.inp")), TOP / "verification/trouble/box.inp"]
        self.decks = (manual, manual, patches, bad, silent)
        self.files = {kind: self.pairs(kind) for kind in (MESHES, SPLINES)}

    def pairs(self, kinds):
        """[(deck, file that it reads)] for files of these kinds."""
        found = []
        for deck in sorted({d for group in self.decks for d in group}):
            found += [(deck, f) for f in companions(deck) if f.name.endswith(kinds)]
        return [p for p in found if p[1].suffix != ".txt" or (kinds == SPLINES) == is_spline(p[0])]

    def folder(self):
        return Path(tempfile.mkdtemp(dir=self.top))

    def call(self, *arguments, seconds=20, **more):
        return call(self.bezel, *arguments, seconds=seconds * self.slow, **more)

    def whole(self, deck, *options):
        """Folder, seconds and number of commands of an uninterrupted run."""
        with self.lock:
            key = (deck, options)
            if key not in self.known:
                at = self.folder()
                done = self.call(at, at / "out", *options, deck, seconds=60)
                if done.code != 0:
                    raise RuntimeError(f"{deck.name} ends with code {done.code}: {done.stderr}")
                report = json.loads((at / "out" / f"{deck.stem}.report.json").read_text())
                commands = 2 * report["iterations"] + 4 * report["steps"]  # about
                self.known[key] = (at / "out", done.seconds, commands)
            return self.known[key]


def is_spline(deck):
    return re.search(r"^\s*SPLI", deck.read_text(errors="replace"), re.M | re.I) is not None


def companions(deck):
    """Files of less than 300 kB that are named in the deck, without decks."""
    text = deck.read_text(errors="replace")
    words = set(re.findall(r"[\w./-]+\.\w+", text))
    found = [deck.parent / w for w in sorted(words) if (deck.parent / w).is_file()]
    return [f for f in found if f.suffix != ".inp" and f.stat().st_size < 300_000]


def set_up(context, deck):
    """Make a folder with the deck and the files it reads, under the same names."""
    home = context.folder()
    names = {deck.name: deck.read_bytes()}
    waiting = companions(deck)
    while waiting:
        file = waiting.pop()
        name = os.path.relpath(file, deck.parent)
        if name.startswith("..") or name in names:
            continue
        names[name] = file.read_bytes()
        waiting += companions(file)
    for name, content in names.items():
        (home / name).parent.mkdir(parents=True, exist_ok=True)
        (home / name).write_bytes(content)
    return home, names


# --- mutated files -------------------------------------------------------------------------------
def mutated(context, chance, deck, file):
    """Run a deck after mutating one of its files; if something is wrong, minimise that file."""
    home, names = set_up(context, deck)
    name = os.path.relpath(file, deck.parent)
    if name not in names:
        name = deck.name
    data = mutate_text(names[name], chance, name, name.endswith((".inp", ".inc")))

    def run(content):
        (home / name).write_bytes(content)
        before = {home / n: content if n == name else names[n] for n in names}
        shutil.rmtree(home / "out", ignore_errors=True)
        done = context.call(
            home, "out", *LIMIT, deck.name, limits=ROOM if context.slow <= 1 else ()
        )
        return done, judge(done, home / "out", (0, 1, 2, 3, 4), before)

    done, wrong = run(data)
    failure = None
    if wrong:
        kind = wrong.split(":")[0]
        small = data
        if kind != "hang":
            small = minimise(data, lambda content: run(content)[1].split(":")[0] == kind)
        failure = Failure(wrong, {**names, name: small}, f"--time-limit 3 {deck.name}")
    shutil.rmtree(home, ignore_errors=True)
    return done.code, failure


def deck_trial(context, chance):
    deck = chance.choice(chance.choice(context.decks))
    return mutated(context, chance, deck, deck)


def mesh_trial(context, chance):
    return mutated(context, chance, *chance.choice(context.files[MESHES]))


def spline_trial(context, chance):
    return mutated(context, chance, *chance.choice(context.files[SPLINES]))


def restart_trial(context, chance):
    """A damaged checkpoint must be rejected, or be read as if it were intact."""
    deck = chance.choice(list(KILLED))
    whole, _, commands = context.whole(deck)
    key = ("stopped", deck)
    with context.lock:
        if key not in context.known:
            at = context.folder()
            # a stop near the end, so that the restarted run is short
            stop = int(0.9 * commands)
            while context.call(at, at / "out", deck, stop=stop, seconds=60).code != STOPPED:
                stop = int(0.8 * stop)
                shutil.rmtree(at / "out", ignore_errors=True)
            context.known[key] = at / "out"
    home = context.folder()
    shutil.copytree(context.known[key], home / "out")
    checkpoint = home / "out" / f"{deck.stem}.restart.h5"
    damage = mutate_checkpoint(checkpoint, chance)
    damaged = checkpoint.read_bytes()
    before = inputs_of(home)
    done = context.call(home, "out", "--restart", checkpoint, deck, limits=ROOM)
    if checkpoint.read_bytes() == damaged:  # the checkpoint is not an output of this run
        done.files.remove(checkpoint)
    wrong = ""
    if done.code == 1:
        done.files = []
        if inputs_of(home) != before:
            wrong = "input: a file was changed although the exit code is 1"
    wrong = wrong or judge(done, home / "out", (0, 1, 3), place=False)
    if not wrong and done.code == 0:
        wrong = difference(whole, home / "out", deck.stem) or ""
        wrong = wrong and f"restart: {wrong}"
    shutil.rmtree(home, ignore_errors=True)
    if not wrong:
        return done.code, None
    return done.code, Failure(
        f"{wrong} ({damage})",
        {deck.name: deck.read_bytes(), checkpoint.name: damaged},
        f"--restart {checkpoint.name} {deck.name}",
    )


def options_trial(context, chance):
    """Options of the program with nonsensical values."""
    home = context.folder()
    (home / "box.inp").write_bytes((TOP / "verification/trouble/box.inp").read_bytes())
    value = lambda: chance.choice(
        (*EXTREMES, *NAMES, "", " ", ".", "/", "/dev/zero", "box.inp", "out")
    )
    words = ["-o", "out", "box.inp"]
    for _ in range(chance.randint(1, 3)):
        name = chance.choice(OPTIONS)
        extra = [name]
        if chance.random() < 0.9:
            extra.append(f"{chance.choice('n lz nu way ends x'.split())}={value()}" if name == "--set" and chance.random() < 0.8 else value())  # fmt: skip
        at = chance.randint(0, len(words))
        words[at:at] = extra
    words = [w.replace("\0", "") for w in words if len(w) < 70000]
    before = inputs_of(home)
    done = context.call(home, None, *LIMIT, *words, limits=ROOM)
    done.files = [f for f in sorted(home.rglob("*")) if f.is_file() and f not in before]
    if "--check" in words or "--list" in words:
        done.files = [] if done.code in (0, 1) else done.files
        wrong = "" if done.code == 0 else judge(done, home, (0, 1, 3, 4), before, place=False)
    else:
        wrong = judge(done, home, (0, 1, 2, 3, 4), before, place=False)
    shutil.rmtree(home, ignore_errors=True)
    how = " ".join(repr(w) for w in words)
    return done.code, Failure(f"{wrong} ({how[:300]})", {}, how) if wrong else None


# --- kills, stops and signals --------------------------------------------------------------------
def readable(out):
    """After a kill, which of the files written so far cannot be read; empty if all can be."""
    for file in sorted(out.glob("*")):
        try:
            if file.suffix == ".dat" and b"\n" in file.read_bytes():
                check_curve(file)
            if file.suffix == ".vtkhdf":
                datasets(file)
        except (OSError, ValueError) as error:
            return f"output: after a kill {file.suffix} cannot be read: {error}"
    return ""


def go_on(context, home, deck, **more):
    checkpoint = home / "out" / f"{deck.stem}.restart.h5"
    options = ("--restart", checkpoint) if checkpoint.exists() else ()
    return context.call(home, "out", *options, deck, seconds=60, **more)


def finished(context, home, deck, history, wrong=""):
    """Continue a run to its end, and compare it with the uninterrupted run."""
    whole, _, _ = context.whole(deck)
    done = None
    if not wrong:
        done = go_on(context, home, deck)
        wrong = judge(done, home / "out", (0,))
        if wrong:
            wrong += f" [{done.stderr.splitlines()[:1]}]"
        else:
            wrong = difference(whole, home / "out", deck.stem) or ""
            wrong = wrong and f"restart: {wrong}"
    shutil.rmtree(home, ignore_errors=True)
    failure = Failure(f"{wrong} ({history})", {deck.name: deck.read_bytes()}) if wrong else None
    return done.code if done else None, failure


def kill_trial(context, chance):
    """Send SIGKILL at one to three random moments."""
    deck = chance.choice(list(KILLED))
    _, seconds, _ = context.whole(deck)
    home, history, wrong = context.folder(), [], ""
    for _ in range(chance.choice((1, 1, 2, 3))):
        wait = chance.uniform(0.0, 1.0) * seconds
        history.append(f"{wait:.3f} s")
        go_on(context, home, deck, send=(signal.SIGKILL, wait))
        wrong = readable(home / "out")
        if wrong:
            break
    return finished(context, home, deck, f"{deck.stem} killed after " + ", ".join(history), wrong)


def stop_trial(context, chance):
    """Stop before a random command, which may be between iterations, cut-backs or output."""
    deck = chance.choice(list(KILLED))
    _, _, commands = context.whole(deck)
    home, history, wrong = context.folder(), [], ""
    for _ in range(chance.choice((1, 2, 3))):
        stop = chance.randint(1, commands)
        done = go_on(context, home, deck, stop=stop)
        history.append(f"before command {stop}")
        wrong = judge(done, home / "out", (0, STOPPED))
        if wrong or done.code == 0:
            break
    return finished(context, home, deck, f"{deck.stem} stopped " + ", ".join(history), wrong)


def signal_trial(context, chance):
    """Send a signal at a random moment; in every third trial, while the deck is being read."""
    deck = chance.choice(list(KILLED))
    _, seconds, _ = context.whole(deck)
    number = chance.choice(STOPS)
    wait = chance.uniform(0.0, EARLY) if chance.random() < 0.35 else chance.uniform(0.0, seconds)
    home = context.folder()
    done = context.call(home, "out", deck, send=(number, wait), seconds=60)
    history = f"{deck.stem}, {number.name} after {1000 * wait:.1f} ms"
    if done.code == -number and not done.files and not done.ready:
        # the system was still loading the program
        shutil.rmtree(home, ignore_errors=True)
        return done.code, None
    wrong = judge(done, home / "out", (0, STOPPED))
    code, failure = finished(context, home, deck, history, wrong)
    return done.code if failure is None else code, failure


# --- limits --------------------------------------------------------------------------------------
def disk_trial(context, chance):
    """A disk, or a limit on the size of a file, that is too small: the exit code must be 3, and
    everything written before must be readable.
    """
    deck = chance.choice(list(KILLED))
    whole, _, _ = context.whole(deck)
    size = sum(f.stat().st_size for f in whole.iterdir())
    room = int(1024 * (size / 1024) ** chance.uniform(0.0, 1.02))
    home = context.folder()
    mounted = can_mount() and chance.random() < 0.6
    limits = ()
    if mounted:
        (home / "out").mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={room}", "none", home / "out"], check=True)  # fmt: skip
    else:
        limits = ((resource.RLIMIT_FSIZE, 0 if chance.random() < 0.05 else room),)
    try:
        done = context.call(home, "out", deck, limits=limits, seconds=60)
        # if there is no room for the report, a run may end without one
        wrong = judge(done, home / "out", (0, 3))
        wrong = wrong or readable(home / "out")
    finally:
        if mounted:
            subprocess.run(["umount", home / "out"], check=False)
    shutil.rmtree(home, ignore_errors=True)
    what = f"{'disk' if mounted else 'file size'} of {room} bytes, {deck.stem}"
    return done.code, Failure(f"{wrong} ({what})") if wrong else None


def can_mount():
    return (
        os.geteuid() == 0 and shutil.which("mount") is not None and not Path("/.nomount").exists()
    )


def memory_trial(context, chance):
    """An address space that is too small: the exit code must be 3, and the program must not wait
    forever.
    """
    deck = chance.choice(list(KILLED))
    threads = chance.choice((1, 1, 2))
    megabytes = int(60 * (2000 / 60) ** chance.random())
    home = context.folder()
    done = context.call(
        home, "out", "--threads", threads, deck, limits=((resource.RLIMIT_AS, megabytes * 2**20),)
    )
    wrong = judge(done, home / "out", (0, 3))
    if wrong and not wrong.startswith("hang") and not done.files and not loads(context, megabytes):
        wrong = ""
    shutil.rmtree(home, ignore_errors=True)
    what = f"{megabytes} MB, {threads} threads, {deck.stem}; {done.stderr[:100]!r}"
    return done.code, Failure(f"{wrong} ({what})") if wrong else None


def loads(context, megabytes):
    """Whether this address space is large enough for the program to start. If not, the system's
    loader, the Fortran library or another library ends with a code and a message of its own.
    """
    limits = ((resource.RLIMIT_AS, megabytes * 2**20),)
    return context.call(context.folder(), None, "--version", limits=limits).code == 0


def units_trial(context, chance):
    """Lengths, stresses and times in units of 1e-9 to 1e12 must give the same curves."""
    deck = chance.choice(list(KILLED))
    whole, _, _ = context.whole(deck)
    unit = [chance.choice((1.0, chance.uniform(1, 10))) * 10.0 ** chance.randint(-9, 12) for _ in "lst"]  # fmt: skip
    words = [f"{n}={v!r}" for n, v in zip("lst", unit, strict=True)]
    settings = [part for word in words for part in ("--set", word)]
    home = context.folder()
    done = context.call(home, "out", *settings, deck, seconds=60)
    wrong = judge(done, home / "out", (0,))
    if wrong:
        wrong += f" [{done.stderr.splitlines()[:1]}]"
    else:
        read = lambda at: np.loadtxt(at / f"{deck.stem}_force.dat", ndmin=2)
        wrong = in_units(read(whole), read(home / "out"), KILLED[deck], unit)
    shutil.rmtree(home, ignore_errors=True)
    how = " ".join(settings) + f" {deck.name}"
    failure = Failure(f"{wrong} ({how})", {deck.name: deck.read_bytes()}, how) if wrong else None
    return done.code, failure


def in_units(one, other, powers, unit):
    """How the rows of a curve in other units differ; empty if they do not."""
    if one.shape != other.shape:
        return f"units: {len(other)} rows instead of {len(one)}"
    scale = [np.prod([u**p for u, p in zip(unit, row, strict=True)]) for row in powers]
    columns = [1, *range(one.shape[1] - len(scale), one.shape[1])]
    for column, factor in zip(columns, [unit[2], *scale], strict=True):
        error = np.abs(other[:, column] / factor - one[:, column]).max()
        if not error <= EQUAL * np.abs(one[:, column]).max():
            return (
                f"units: column {column + 1} differs by {error / np.abs(one[:, column]).max():.1e}"
            )
    return ""


#: Trials in each round; a run repeats whole rounds, each in random order, as long as there is time.
KINDS = {
    "deck": (deck_trial, 50),
    "mesh": (mesh_trial, 9),
    "spline": (spline_trial, 9),
    "options": (options_trial, 5),
    "restart": (restart_trial, 7),
    "kill": (kill_trial, 7),
    "stop": (stop_trial, 3),
    "signal": (signal_trial, 4),
    "disk": (disk_trial, 2),
    "memory": (memory_trial, 3),
    "units": (units_trial, 1),
}
FUZZ = ("deck", "mesh", "spline")


def trial(context, seed, kind, number):
    """Make one trial; the same three arguments give the same trial."""
    return KINDS[kind][0](context, random.Random(f"{seed}.{kind}.{number}"))


def schedule(seed, kinds):
    """An endless sequence of (kind, number)."""
    done = dict.fromkeys(KINDS, 0)
    turn = 0
    while True:
        names = [name for name in KINDS if name in kinds for _ in range(KINDS[name][1])]
        random.Random(f"{seed}.{turn}").shuffle(names)
        turn += 1
        for name in names:
            done[name] += 1
            yield name, done[name]
