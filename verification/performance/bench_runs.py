"""The runs of `make bench`: one process and one thread each, with wall-clock and CPU seconds."""

import json
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import time

from verification.performance import calculix_cube

HERE = pathlib.Path(__file__).resolve().parent
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "CCX_NPROC_STIFFNESS")
LIMIT = 3600  # seconds after which a run is stopped


class Unavailable(Exception):
    """A program is missing or does not work; the text is one sentence about it."""


def measure(command, folder, limit_mb=None):
    """Run a command; return (wall-clock seconds, CPU seconds, peak MB, exit code, output,
    errors).
    """

    def limit_memory():
        if limit_mb:
            resource.setrlimit(resource.RLIMIT_AS, (int(limit_mb * 2**20),) * 2)

    environment = os.environ | dict.fromkeys(THREADS, "1")
    out, err = folder / "stdout.txt", folder / "stderr.txt"
    start = time.perf_counter()
    with out.open("w") as o, err.open("w") as e:
        child = subprocess.Popen(
            command, cwd=folder, stdout=o, stderr=e, env=environment, preexec_fn=limit_memory
        )
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    wall = time.perf_counter() - start
    cpu = used.ru_utime + used.ru_stime
    texts = [p.read_text(errors="replace") for p in (out, err)]
    return wall, cpu, used.ru_maxrss / 1024, child.returncode, *texts


def deck(folder, name, element, factor):
    """Write cube.inp with another element or another FACTor; return its path."""
    text = (HERE / "cube.inp").read_text().replace("TYPE Q1\n", f"TYPE {element}\n")
    if factor:
        text = text.replace("BATCh\n", f"BATCh\n  FACTor {factor}\n")
    path = folder / f"{name}.inp"
    path.write_text(text)
    return path


def run_bezel(bezel, folder, name, n, element="Q1", factor="", steps=5, limit_mb=None):
    """Make one run; return {"wall", "cpu", "iterations", "force", "share", "memory", ...}."""
    path = deck(folder, name, element, factor)
    command = [bezel, "--quiet", "--threads", "1", "--set", f"n={n}", "--set", f"steps={steps}"]
    wall, cpu, memory, code, _, errors = measure([*command, str(path)], folder, limit_mb)
    if code:
        return {"code": code, "message": errors.strip(), "memory": memory, "wall": wall}
    report = json.loads((folder / f"{name}.report.json").read_text())
    seconds = report["seconds"]
    return {
        "wall": wall,
        "cpu": cpu,
        "iterations": report["iterations"],
        "force": report["final"]["force"]["force_3"],
        "share": seconds["assembly"] / seconds["total"],
        "memory": memory,
        "equations": report["equations"],
        "version": f"bezel {report['version']}",
    }


def run_felupe(folder, n, solver):
    """The same run with FElupe; the seconds are those of the iterations alone."""
    command = [sys.executable, str(HERE / "felupe_cube.py"), str(n), solver]
    _, _, memory, code, output, errors = measure(command, folder)
    if code:
        last = (errors.strip().splitlines() or ["no message"])[-1]
        raise Unavailable(f"FElupe with {solver} does not run ({last})")
    return json.loads(output.strip().splitlines()[-1]) | {"memory": memory}


def run_calculix(folder, n):
    """The same run with CalculiX; the seconds are those of the whole process."""
    program = shutil.which("ccx")
    if not program:
        raise Unavailable("CalculiX is not installed (apt install calculix-ccx)")
    calculix_cube.write_input(folder / "cube.inp", n)
    wall, cpu, memory, code, output, _ = measure([program, "cube"], folder)
    if code or "convergence" not in output:
        raise Unavailable(f"CalculiX does not run (exit code {code})")
    found = calculix_cube.read_output(folder, output)
    return {"wall": wall, "cpu": cpu, "memory": memory} | found


def run_program(path, folder, arguments):
    """Run a program that times a part of bezel; return its output."""
    *_, code, output, errors = measure([str(path), *arguments], folder)
    return output if code == 0 else f"exit code {code}\n{errors}"


def machine(bezel_programs):
    """Processor, memory, load, versions and BLAS kernel."""
    info = pathlib.Path("/proc/cpuinfo").read_text()
    cpu = re.search(r"model name\s*:\s*(.*)", info)
    family = re.search(r"cpu family\s*:\s*(\d+)", info)
    model = re.search(r"model\s*:\s*(\d+)", info)
    memory = re.search(r"MemTotal:\s*(\d+)", pathlib.Path("/proc/meminfo").read_text())
    kernel = re.search(r"BLAS kernel (\w+)", bezel_programs)
    compiler = subprocess.run(["gfortran", "-dumpfullversion"], capture_output=True, text=True)
    return {
        "cpu": f"{cpu[1]}, family {family[1]}, model {model[1]}" if cpu and model else "unknown",
        "cores": os.cpu_count(),
        "memory_gib": round(int(memory[1]) / 2**20, 1),
        "load": [round(x, 1) for x in os.getloadavg()],
        "blas_kernel": kernel[1] if kernel else "unknown",
        "gfortran": compiler.stdout.strip(),
        "mumps": library_version("libdmumps_seq"),
        "openblas": library_version("libopenblasp"),
    }


def library_version(stem):
    """The version in the file name of an installed library, or an empty string."""
    for path in sorted(pathlib.Path("/usr/lib").glob(f"**/{stem}*.so*")):
        found = re.search(r"(\d+\.\d+\.\d+)", path.resolve().name)
        if found:
            return found[1]
    return ""
