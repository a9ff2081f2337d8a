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


def report(strahl, data):
    """Prints the table; whether Strahl is no slower and keeps below 1.3 times the decoded size."""
    good = True
    print(f"medians of {RUNS} runs, taken in turns; memory is the peak of the whole process")
    for name, code in PYTHON.items():
        path = Path(data) / name
        if not path.exists():
            print(f"skipped: no {name} in {data}")
            continue
        ours, idle, theirs = [], [], []
        for _ in range(RUNS):
            ours.append(run([strahl, "info", path, "--json"]))
            idle.append(run([strahl, "presets"]))
            theirs.append(run([sys.executable, "-c", code, path]))
        decoded = int(theirs[0][3].split()[0]) / 2**20
        reading = statistics.median(float(one[3].split()[1]) for one in theirs)

        def median(runs, column):
            return statistics.median(one[column] for one in runs)

        print(f"{name}: {decoded:.1f} MiB decoded")
        for title, runs in (
            ("strahl info", ours),
            ("strahl, start alone", idle),
            ("python", theirs),
        ):
            print(
                f"  {title:<20} {median(runs, 0):6.3f} s wall {median(runs, 1):6.3f} s processor "
                f"{median(runs, 2):6.1f} MiB"
            )
        print(f"  {'python, reading alone':<20} {reading:5.3f} s wall")
        time_ratio = median(ours, 0) / reading
        memory_ratio = median(ours, 2) / decoded
        print(
            f"  strahl: {time_ratio:.2f} of the time that Python reads (start of Python not "
            f"counted), memory {memory_ratio:.2f} of the decoded size"
        )
        good &= time_ratio <= 1 and memory_ratio <= 1.3
    return good


if __name__ == "__main__":
    sys.exit(0 if report(*sys.argv[1:]) else 1)
