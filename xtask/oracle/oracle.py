"""Compares what Strahl reads and writes with independent libraries; see CONTRIBUTING.md."""

import argparse
import shutil
import subprocess
import sys
import time
import warnings
from collections import Counter
from pathlib import Path

import array_cases
import case
import color_cases
import dicom_cases
import format_cases
import metaimage_cases
import nifti_cases
import nrrd_cases
import shared_cases
import slice_cases
import writers

FAMILIES = {
    "nifti": nifti_cases.cases,
    "nrrd": nrrd_cases.cases,
    "metaimage": metaimage_cases.cases,
    "arrays": array_cases.cases,
    "slices": slice_cases.cases,
    "dicom": dicom_cases.cases,
    "formats": format_cases.cases,
    "color": color_cases.cases,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--strahl", required=True, type=Path)
    parser.add_argument("--data", required=True, type=Path)
    parser.add_argument("--scratch", required=True, type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--time", type=Path, help="the program that reads through the library")
    parser.add_argument("--verbose", action="store_true")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")

    if arguments.time:
        # In a process of its own, small enough to measure small ones.
        script = Path(__file__).with_name("timing.py")
        programs = [arguments.strahl, arguments.time]
        return subprocess.call([sys.executable, script, *programs, arguments.data])

    shutil.rmtree(arguments.scratch, ignore_errors=True)
    arguments.scratch.mkdir(parents=True)
    strahl = case.Strahl(arguments.strahl, arguments.scratch)
    compared, wrong = Counter(), Counter()
    start = time.perf_counter()

    def tell(name, problems):
        family = name.split("/")[0]
        compared[family] += 1
        wrong[family] += bool(problems)
        for problem in problems:
            print(f"MISMATCH {name}: {problem}")
        if arguments.verbose and not problems:
            print(f"ok       {name}")

    # `--only dicom` and `--only dicom/tilt` need not write the files of the other families.
    chosen = arguments.only.split("/")[0]
    named = [*FAMILIES, "shared", "write"]
    wanted = [family for family in named if chosen in family] or named

    for family, cases in FAMILIES.items():
        if family not in wanted:
            continue
        folder = arguments.scratch / family
        folder.mkdir()
        for one in cases(folder):
            if arguments.only in one.name:
                tell(one.name, case.check(one, strahl))
    if "shared" in wanted:
        if not arguments.data.is_dir():
            print(f"skipped: no scans in {arguments.data}")
        for one in shared_cases.cases(arguments.data):
            if arguments.only in one.name:
                tell(one.name, case.check(one, strahl))
    if "write" in wanted:
        folder = arguments.scratch / "write"
        folder.mkdir()
        for name, problems in writers.checks(folder, strahl):
            tell(name, problems)

    print(f"\n{'family':<12} {'files':>6} {'mismatches':>11}")
    for family, count in compared.items():
        print(f"{family:<12} {count:>6} {wrong[family]:>11}")
    print(
        f"{'all':<12} {compared.total():>6} {wrong.total():>11}"
        f"   ({time.perf_counter() - start:.0f} s, {strahl.count} runs of strahl)"
    )
    return 1 if wrong.total() or not compared.total() else 0


if __name__ == "__main__":
    sys.exit(main())
