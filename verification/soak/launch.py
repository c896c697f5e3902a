"""One call of the program, and what is wrong with it."""

import json
import math
import os
import pathlib
import re
import resource
import signal
import subprocess
import time
from dataclasses import dataclass, field

from verification.mutate import has_nan

BUSY = 6  # largest ratio of wall-clock to CPU seconds
CODES = {0: "done", 2: "no_solution", 3: "failed", 4: "stopped"}  # exit code: status in the report
PARTIAL = (".lock", ".part")
CRASH = re.compile(
    r"Backtrace for|Program received signal|SIGSEGV|Fortran runtime error|AddressSanitizer"
    r"|LeakSanitizer|runtime error:|terminate called|double free|HDF5-DIAG|Error in `"
)
#: Messages of errors that are not the fault of a particular line of the deck.
NO_PLACE = (
    "cannot be read",
    "is a folder",
    "is not a regular file",
    "is not a text file",
    "is empty",
    "--set",
    "would overwrite",
    "belongs to another",
    "was written by version",
    "checkpoint format",
)
HEAD = re.compile(r"^(?:(?P<place>[^\n]*?:\d+(?::\d+)?): )?error: (?P<text>.*)$")


@dataclass
class Call:
    """The outcome of one call."""

    code: int | None  # None: it did not end in time; negative: minus the signal that ended it
    stderr: str = ""
    seconds: float = 0.0
    files: list = field(default_factory=list)
    ready: bool = True  # whether the program caught or blocked the signal when it was sent


def call(bezel, home, out, *arguments, seconds=20, limits=(), send=None, stop=None):
    """Run the program in the folder `home` with its results in `out`.

    limits: pairs of a resource and a number; send: (signal, delay); stop: see verification.recover.
    """
    env = {k: v for k, v in os.environ.items() if not k.startswith(("BEZEL_", "OPENBLAS_NUM"))}
    env["OMP_NUM_THREADS"] = "1"
    if stop:
        env["BEZEL_STOP"] = str(stop)
    most = math.ceil(seconds)

    def prepare():
        signal.signal(signal.SIGHUP, signal.SIG_DFL)  # under nohup it would be ignored
        resource.setrlimit(resource.RLIMIT_CPU, (most, most + 2))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        for kind, value in limits:
            resource.setrlimit(kind, (value, value))

    ready = True
    begin = time.monotonic()
    process = subprocess.Popen(
        [str(bezel), "--quiet", *(["-o", str(out)] if out else []), *map(str, arguments)], cwd=home, env=env,
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        preexec_fn=prepare)  # fmt: skip
    try:
        if send:
            time.sleep(send[1])
            ready = heeds(process.pid, send[0])
            process.send_signal(send[0])
        _, stderr = process.communicate(timeout=BUSY * seconds)
        code = process.returncode
    except subprocess.TimeoutExpired:
        process.kill()
        _, stderr = process.communicate()
        code = None
    spent = time.monotonic() - begin
    out = pathlib.Path(home, out or ".")
    files = sorted(f for f in out.rglob("*") if f.is_file()) if out.exists() else []
    return Call(code, stderr.decode(errors="replace"), spent, files, ready)


def heeds(process, number):
    """Whether a process catches or blocks a signal at present; while the system is still loading
    the program, it does neither.
    """
    try:
        text = pathlib.Path(f"/proc/{process}/status").read_text()
    except OSError:
        return False
    masks = re.findall(r"^Sig(?:Blk|Cgt):\s*([0-9a-f]+)", text, re.M)
    return any(int(mask, 16) >> (number - 1) & 1 for mask in masks)


def errors(stderr):
    """The error messages on standard error: [(kind, whether it has a caret, text)].

    The kind is 'column', 'line' or '', after the place that the message gives.
    """
    lines, found = stderr.split("\n"), []
    for i, line in enumerate(lines):
        match = HEAD.match(line)
        if match:
            caret = i + 2 < len(lines) and lines[i + 2].strip(" \t|").startswith("^")
            place = match["place"] or ""
            kind = "column" if re.search(r":\d+:\d+$", place) else "line" if place else ""
            found.append((kind, caret, match["text"]))
    return found


def inputs_of(home):
    """{path: bytes} of every file that a run may read."""
    return {f: f.read_bytes() for f in sorted(pathlib.Path(home).rglob("*")) if f.is_file()}


def judge(done, out, codes=(0, 1, 2, 3), before=None, place=True):
    """What is wrong with a call, in one line that begins with a word for the kind of failure; empty
    if nothing is wrong.

    before: inputs_of before the call; place: whether an error of the deck must name a line.
    """
    if done.code is None or -done.code in (signal.SIGXCPU, signal.SIGKILL):
        return "hang: it did not end in time"
    if done.code < 0:
        return f"crash: signal {-done.code}"
    if CRASH.search(done.stderr):
        return "crash: " + CRASH.search(done.stderr)[0]
    if done.code not in codes:
        return f"code: {done.code}"
    if before is not None:
        for path, content in before.items():
            if not path.exists() or path.read_bytes() != content:
                return f"input: {path.name} was changed"
    said = errors(done.stderr)
    if done.code != 0:
        if not said:
            return f"message: none, exit code {done.code}"
        texts = [text for _, _, text in said]
        if done.code != 1 and len(said) > 1:
            return f"message: {len(said)} errors, exit code {done.code}"
        heads = [line for line in done.stderr.split("\n") if HEAD.match(line)]
        if len(said) > 10 or len(set(heads)) < len(heads):
            return f"message: printed twice or too many: '{texts[0][:60]}'"
        if done.code == 1 and place:
            for has_place, has_caret, text in said:
                if has_place == "column" and not has_caret:
                    return f"caret: none below '{text[:60]}'"
                if not has_place and not any(word in text for word in NO_PLACE):
                    return f"place: no line is named by '{texts[0][:60]}'"
    if done.code == 1:
        return "files: they were written with exit code 1" if done.files else ""
    return judge_files(done, out)


def judge_files(done, out):
    """What is wrong with the files of a run that has begun; empty if nothing is wrong."""
    for file in done.files:
        if file.suffix in PARTIAL:
            return f"left: a file *{file.suffix}"
    reports = [f for f in done.files if f.name.endswith(".report.json")]
    if len(reports) != 1:
        return "" if done.code == 3 else f"output: {len(reports)} reports"
    try:
        report = json.loads(reports[0].read_text())
        if report["exit_code"] != done.code or report["status"] != CODES[done.code]:
            return "output: the report has another exit code"
        for file in done.files:
            if has_nan(file):
                return f"number: a NaN in *{file.suffix}"
            if file.suffix == ".dat":
                check_curve(file)
    except (OSError, ValueError, KeyError) as error:
        return (
            f"output: {type(error).__name__} in {file.suffix if 'file' in locals() else 'report'}"
        )
    return ""


def check_curve(path):
    """Require that every complete row of a curve has as many numbers as there are columns, all of
    them finite.
    """
    head, *rows = path.read_text().splitlines(keepends=True)
    for row in rows:
        if row.endswith("\n"):
            numbers = [float(word) for word in row.split()]
            if not all(map(math.isfinite, numbers)):
                raise ValueError("not finite")
            if len(numbers) != len(head.split()) - 1:
                raise ValueError("short row")
