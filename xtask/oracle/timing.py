"""Time and memory of reading, beside the Python libraries, each run in a process of its own.

This script imports nothing large: the peak that the system reports of a process is at least that
of its parent at the moment of its start.
"""

import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

RUNS = 9

# Both sides read, decode and look at every sample once: Strahl for its range and histogram, Python
# for the smallest and the largest. They print the decoded bytes and the seconds of reading alone.
PYTHON = {
    "bonsai.nii.gz": """
import sys, time, nibabel, numpy
start = time.perf_counter()
data = numpy.asanyarray(nibabel.load(sys.argv[1]).dataobj)
data.min(), data.max()
print(data.nbytes, time.perf_counter() - start)
""",
    "head-mr-dicom": """
import glob, sys, time, numpy, pydicom, pydicom.pixels
start = time.perf_counter()
files = [pydicom.dcmread(path) for path in glob.glob(sys.argv[1] + '/*')]
x, y = numpy.array(files[0].ImageOrientationPatient, float).reshape(2, 3)
normal = numpy.cross(x, y)
files.sort(key=lambda f: normal @ numpy.array(f.ImagePositionPatient, float))
data = numpy.stack([file.pixel_array for file in files])
data.min(), data.max()
print(data.nbytes, time.perf_counter() - start)
""",
}


def run(command):
    """Wall time in seconds, processor time in seconds, peak memory in MiB, what it printed."""
    start = time.perf_counter()
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, text=True)
    said = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - start
    if status != 0:
        sys.exit(f"failed: {command}")
    return seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, said


def report(strahl, library, data):
    """Prints the table; whether Strahl is no slower and keeps below 1.3 times the decoded size.

    Like is compared with like: `library` is a program that does through `strahl::load` what the
    scripts do through their libraries. The whole command line, with code for drawing and graphics
    drivers linked in, is shown beside it.
    """
    good = True
    print(f"medians of {RUNS} runs, taken in turns; memory is the peak of the whole process")
    for name, code in PYTHON.items():
        path = Path(data) / name
        if not path.exists():
            print(f"skipped: no {name} in {data}")
            continue
        ours, info, theirs = [], [], []
        for _ in range(RUNS):
            ours.append(run([library, path]))
            info.append(run([strahl, "info", path, "--json"]))
            theirs.append(run([sys.executable, "-c", code, path]))

        def median(runs, column):
            return statistics.median(one[column] for one in runs)

        def said(runs, word):
            return statistics.median(float(one[3].split()[word]) for one in runs)

        decoded = said(ours, 0) / 2**20
        good &= said(theirs, 0) == said(ours, 0)
        print(f"{name}: {decoded:.1f} MiB decoded")
        for title, runs in (
            ("strahl::load", ours),
            ("strahl info", info),
            ("python", theirs),
        ):
            reading = "       -" if runs is info else f"{said(runs, 1):6.3f} s"
            print(
                f"  {title:<13} reading {reading}, process {median(runs, 0):6.3f} s wall "
                f"{median(runs, 1):6.3f} s processor {median(runs, 2):6.1f} MiB, "
                f"{median(runs, 2) / decoded:.2f} of the decoded size"
            )
        time_ratio = said(ours, 1) / said(theirs, 1)
        print(f"  strahl::load reads in {time_ratio:.2f} of the time that Python reads in")
        good &= time_ratio <= 1 and median(ours, 2) / decoded <= 1.3
    return good


if __name__ == "__main__":
    sys.exit(0 if report(*sys.argv[1:]) else 1)
