"""Compares gmpcr with Open3D and GTSAM on the same data, the same machine and one core.

A  pose graphs without outlier edges (sphere2500, parking-garage): value of the objective reached
B  simulated pose graphs with up to 40 % outlier edges: rotation errors
C  20 scans of a room, from files to poses: pairs registered

Every run is a process of its own with a limit on its CPU time and its memory. What cannot run
because a package, the program or the data is missing is skipped and named. See README.md.
"""

import argparse
import importlib.metadata
import importlib.util
import itertools
import json
import os
import platform
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path

try:
    import numpy as np
except ImportError:
    sys.exit("numpy is needed, see README.md")

from graphs import angles, objective, read_g2o, rotation_errors, simulate
from peers import NUM_SCANS, ROBUST_SCALE, scan_files

PROJECT = Path(__file__).resolve().parents[2]
ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS")}

# Minima of SE-Sync's objective, certified by SE-Sync (Rosen et al., IJRR 2019).
OPTIMA = {"sphere2500": 1687.006, "parking-garage": 1.26251}


@dataclass
class Run:
    cpu: float
    wall: float
    problem: str = ""
    poses: tuple = None
    stages: dict = field(default_factory=dict)


class Bench:
    def __init__(self, arguments, folder):
        self.gmpcr, self.data = arguments.gmpcr, arguments.data
        self.limit, self.memory = arguments.limit, arguments.memory
        self.folder = Path(folder)

    def missing(self, package):
        """Why the package cannot run, or nothing."""
        if package == "gmpcr":
            return "" if self.gmpcr.is_file() else f"no program {self.gmpcr}"
        return "" if importlib.util.find_spec(package) else f"no Python package {package}"

    def process(self, command, limit, may_return=(0,)):
        """Runs a command to its end or limit. Its output and errors are `out` and `err` in the folder."""
        def restrict():
            if hasattr(os, "sched_setaffinity"):  # some parts of Open3D take all cores they find
                os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
            resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
            resource.setrlimit(resource.RLIMIT_AS, (self.memory << 30,) * 2)
        output, errors = self.folder / "out", self.folder / "err"
        start = time.monotonic()
        with open(output, "w") as out, open(errors, "w") as err:
            environment = os.environ | ONE_THREAD
            process = subprocess.Popen(command, stdout=out, stderr=err, env=environment, preexec_fn=restrict)
            hung = threading.Timer(10 * limit, process.kill)
            hung.start()
            _, status, usage = os.wait4(process.pid, 0)
            hung.cancel()
        process.returncode = code = os.waitstatus_to_exitcode(status)
        run = Run(usage.ru_utime + usage.ru_stime, time.monotonic() - start)
        message = errors.read_text(errors="replace").strip()
        if code == -signal.SIGXCPU:
            run.problem = f"over {limit} s"
        elif any(sign in message for sign in ("bad_alloc", "MemoryError", "memory allocation of")):
            run.problem = f"over {self.memory} GiB"
        elif code not in may_return:
            run.problem = f"failed ({code}): " + (message.splitlines() or [""])[-1][:80].replace("|", "/")
        return run

    def peer(self, name, variant, source, limit=None):
        out = self.folder / "poses.npz"
        script = Path(__file__).with_name("peers.py")
        run = self.process([sys.executable, script, name, variant, source, out], limit or self.limit)
        if not run.problem:
            result = np.load(out)
            run.poses, run.stages = (result["R"], result["t"]), json.loads(str(result["stages"]))
        return run

    def gmpcr_sync(self, method, source):
        out = self.folder / "synchronized.g2o"
        command = [self.gmpcr, "sync", source, "-o", out, "--json", "--method", *method.split()]
        run = self.process(command, self.limit, may_return=(0, 2))
        if not run.problem:
            run.poses = read_g2o(out)[1]
            # The clock of the program runs on where others have the core, so it bounds the CPU time.
            run.stages = {"solve": min(json.loads((self.folder / "out").read_text())["seconds"], run.cpu)}
        return run

    def solve(self, system, source):
        _, package, variant = system
        return self.gmpcr_sync(variant, source) if package == "gmpcr" else self.peer(package, variant, source)


def table(header, rows):
    print("| " + " | ".join(header) + " |\n|" + "---|" * len(header))
    for row in rows:
        print("| " + " | ".join(row) + " |", flush=True)
    print()


def times(run, package):
    """Columns of reading, solving, the whole process, and wall time."""
    cell = lambda name: f"{run.stages[name]:.2f}" if name in run.stages else "–"
    bound = "≤ " if package == "gmpcr" and "solve" in run.stages else ""
    return [cell("read"), bound + cell("solve"), f"{run.cpu:.2f}", f"{run.wall:.2f}"]


TIMES = ["read CPU s", "solve CPU s", "process CPU s", "process wall s"]


def without_outliers(bench):
    # Without iterations: the spectral solution and least squares, no more.
    methods = ("adaptive --iterations 0", "adaptive", "consensus", "l1-irls", "hara", "eigse3")
    systems = [
        ("GTSAM chordal + LM", "gtsam", "plain"),
        ("GTSAM chordal + LM, SE-Sync's weights", "gtsam", "isotropic"),
        ("Open3D global optimization", "open3d", "plain"),
        *[(f"gmpcr {method}", "gmpcr", method) for method in methods],
    ]

    def rows():
        for name, optimum in OPTIMA.items():
            source = bench.data / "g2o" / f"{name}.g2o"
            for system in systems:
                missing = bench.missing(system[1]) or ("" if source.is_file() else f"no file {source}")
                if missing:
                    yield [name, system[0], f"skipped: {missing}"] + ["–"] * 5
                    continue
                run = bench.solve(system, source)
                reached = objective(read_g2o(source)[0], run.poses) if run.poses else None
                values = [f"{reached:.6g}", f"{reached / optimum:.4f}"] if run.poses else [run.problem, "–"]
                yield [name, system[0], *values, *times(run, system[1])]
    table(["graph", "system", "F", "F / F*", *TIMES], rows())


def with_outliers(bench):
    systems = [
        ("GTSAM chordal + LM, Geman-McClure", "gtsam", "robust"),
        ("Open3D global optimization", "open3d", "robust"),
        ("gmpcr adaptive", "gmpcr", "adaptive"),
        ("gmpcr consensus", "gmpcr", "consensus"),
    ]

    def rows():
        for n, outliers in itertools.product((500, 5000), (0.0, 0.2, 0.4)):
            source = bench.folder / "simulated.g2o"
            ground_truth = simulate(n, outliers, source)
            for system in systems:
                label = [str(n), f"{outliers:.0%}", system[0]]
                if bench.missing(system[1]):
                    yield [*label, f"skipped: {bench.missing(system[1])}"] + ["–"] * 5
                    continue
                run = bench.solve(system, source)
                errors = rotation_errors(run.poses[0], ground_truth) if run.poses else None
                values = [f"{errors.mean():.2f}", f"{np.median(errors):.2f}"] if run.poses else [run.problem, "–"]
                yield [*label, *values, *times(run, system[1])]
    table(["N", "outlier edges", "system", "mean error °", "median error °", *TIMES], rows())


def gmpcr_register(bench, scene):
    out = bench.folder / "registered"
    run = bench.process([bench.gmpcr, "register", *scan_files(scene), "-o", out], 10 * bench.limit, may_return=(0, 2))
    if not run.problem:
        result = json.loads((out / "result.json").read_text())
        run.stages = {stage["name"]: stage["seconds"] for stage in result["stages"]}
        rows = np.loadtxt(out / "poses.txt", ndmin=2)
        # Scans outside the largest component have no row.
        poses = np.full((NUM_SCANS, 3, 4), np.nan)
        poses[rows[:, 0].astype(int)] = rows[:, 1:].reshape(-1, 3, 4)
        run.poses = poses[:, :, :3], poses[:, :, 3]
    return run


def read_log(path):
    """Relative poses `i_from_j` of a 3DMatch log, by pair, of the scans used."""
    lines = path.read_text().splitlines()
    blocks = [lines[k:k + 5] for k in range(0, len(lines) - 4, 5)]
    poses = {tuple(map(int, b[0].split()[:2])): np.array([row.split() for row in b[1:]], float) for b in blocks}
    return {pair: pose for pair, pose in poses.items() if max(pair) < NUM_SCANS}


def recall(poses, log):
    """Pairs within 15 degrees and 0.3 m of the ground truth, of how many; their median errors."""
    R, t = poses
    i, j = np.array(list(log)).T
    ground_truth = np.array(list(log.values()))
    back = np.swapaxes(R[i], 1, 2)
    rotation = angles(back @ R[j], ground_truth[:, :3, :3])
    translation = np.linalg.norm(np.einsum("eab,eb->ea", back, t[j] - t[i]) - ground_truth[:, :3, 3], axis=1)
    good = (rotation < 15) & (translation < 0.3)
    medians = f"{np.median(rotation[good]):.2f}° {100 * np.median(translation[good]):.1f} cm" if good.any() else "–"
    return [f"{good.sum()} of {len(log)}", medians]


def whole_pipeline(bench):
    scene = bench.data / "redkitchen"
    logs = [scene / f"official_3d{kind}.log" for kind in ("match", "lomatch")]
    absent = [path for path in [*scan_files(scene), *logs] if not path.is_file()]
    systems = [("Open3D FPFH, RANSAC, global optimization", "open3d"), ("gmpcr register", "gmpcr")]

    def rows():
        for name, package in systems:
            missing = bench.missing(package) or (f"no file {absent[0]}" if absent else "")
            if missing:
                yield [name, f"skipped: {missing}"] + ["–"] * 6
                continue
            if package == "gmpcr":
                run = gmpcr_register(bench, scene)
            else:
                run = bench.peer("open3d-register", "plain", scene, 10 * bench.limit)
            if run.poses:
                values = [value for log in logs for value in recall(run.poses, read_log(log))]
            else:
                values = [run.problem] + ["–"] * 3
            stages = ", ".join(f"{stage} {seconds:.2f}" for stage, seconds in run.stages.items()) or "–"
            yield [name, *values, stages, f"{run.cpu:.2f}", f"{run.wall:.2f}"]
    table(["system", "3DMatch pairs", "medians", "3DLoMatch pairs", "medians", "stages, s", *TIMES[2:]], rows())


PARTS = {
    "A": ("Pose graphs without outlier edges", without_outliers,
          "F is SE-Sync's objective and F* its certified minimum. GTSAM's and Open3D's own objectives differ from "
          "F: they use the whole information matrices; the row with SE-Sync's weights minimizes F up to third order. "
          "gmpcr weighs edges by the trace of the rotation's information and estimates rotations first."),
    "B": ("Simulated pose graphs with outlier edges", with_outliers,
          "Angles to the rotations of the ground truth, one graph per row. GTSAM and Open3D are told the noise (2°, "
          f"5 cm) by the information matrices and reject beyond {ROBUST_SCALE:g} standard deviations; gmpcr runs with "
          "its defaults."),
    "C": (f"{NUM_SCANS} scans of 7-Scenes redkitchen, from files to poses", whole_pipeline,
          "Pairs of the official lists among these scans within 15° and 0.3 m of the ground truth, and the median "
          "errors of those. Stages: CPU seconds of Open3D, wall seconds of gmpcr, each on one thread."),
}


def header(bench):
    models = [platform.processor()]
    if os.path.exists("/proc/cpuinfo"):
        models = [line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
    packages = [name for name in ("open3d", "gtsam", "numpy") if not bench.missing(name)]
    versions = [f"{name} {importlib.metadata.version(name)}" for name in packages]
    if not bench.missing("gmpcr"):
        versions.insert(0, subprocess.run([bench.gmpcr, "--version"], capture_output=True, text=True).stdout.strip())
    print(f"{date.today()}, {models[0]}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}; "
          f"{', '.join(versions)}, Python {platform.python_version()}.\n")
    print("One core and one thread each. CPU seconds (user and system) are the figure to trust, for wall seconds depend "
          f"on what else runs. Limits of a run: {bench.limit} CPU seconds (ten times that in part C), {bench.memory} GiB. "
          "A process includes start, imports and writing. gmpcr's solving is bounded by its own clock.\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--parts", default="A,B,C", help="which parts, such as A,C")
    parser.add_argument("--gmpcr", type=Path, default=PROJECT / "target/release/gmpcr", help="the program")
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("GMPCR_DATA", "data")))
    parser.add_argument("--limit", type=int, default=120, metavar="SECONDS", help="CPU time of a run")
    parser.add_argument("--memory", type=int, default=12, metavar="GIB", help="address space of a run")
    arguments = parser.parse_args()
    parts = arguments.parts.upper().split(",")
    if unknown := set(parts) - set(PARTS):
        parser.error(f"no part {', '.join(sorted(unknown))}: A, B and C there are")
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(arguments, folder)
        header(bench)
        for part in parts:
            title, compare, note = PARTS[part]
            print(f"## {part}. {title}\n\n{note}\n", flush=True)
            compare(bench)


if __name__ == "__main__":
    main()
