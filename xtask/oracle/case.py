"""One comparison: what Strahl says about a file against what another library says."""

import json
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

LPS_FROM_RAS = np.diag([-1.0, -1.0, 1.0, 1.0])

TYPES = ["u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"]


@dataclass
class Case:
    """A file and what must be read from it.

    `stored` has the shape (z, y, x) and the type of the file; `affine` maps voxel indices to RAS mm.
    With `refused` the file must be refused, with this text in the message.
    """

    name: str
    paths: list
    stored: np.ndarray | None = None
    affine: np.ndarray | None = None
    slope: float = 1.0
    intercept: float = 0.0
    flags: list = field(default_factory=list)
    refused: str | None = None
    note: str | None = None
    labels: dict | None = None


class Strahl:
    """Runs the binary."""

    def __init__(self, binary, scratch):
        self.binary = str(binary)
        self.scratch = Path(scratch)
        self.count = 0

    def run(self, *arguments):
        self.count += 1
        return subprocess.run(
            [self.binary, *map(str, arguments)], capture_output=True, text=True, timeout=300
        )

    def info(self, paths, flags=()):
        done = self.run("info", *paths, "--json", *flags)
        if done.returncode != 0:
            return None, done
        return json.loads(done.stdout), done

    def stored(self, paths, flags=()):
        """The stored numbers as (z, y, x), through a NIfTI file that is taken apart by hand."""
        out = self.scratch / "stored.nii"
        done = self.run("convert", *paths, out, "--quiet", *flags)
        if done.returncode != 0:
            raise RuntimeError(done.stderr.strip())
        return stored_of_nifti(out.read_bytes())

    def values(self, paths, flags=()):
        """The values as NumPy reads them back."""
        out = self.scratch / "values.npy"
        done = self.run("convert", *paths, out, "--quiet", *flags)
        if done.returncode != 0:
            raise RuntimeError(done.stderr.strip())
        return np.load(out)


NIFTI_TYPES = {2: "u1", 256: "i1", 512: "u2", 4: "i2", 768: "u4", 8: "i4", 16: "f4", 64: "f8"}


def stored_of_nifti(data):
    version_1 = int.from_bytes(data[:4], "little") == 348
    if version_1:
        dims = np.frombuffer(data, "<i2", 8, 40)
        code = int(np.frombuffer(data, "<i2", 1, 70)[0])
        start = int(np.frombuffer(data, "<f4", 1, 108)[0])
    else:
        dims = np.frombuffer(data, "<i8", 8, 16)
        code = int(np.frombuffer(data, "<i2", 1, 12)[0])
        start = int(np.frombuffer(data, "<i8", 1, 168)[0])
    x, y, z = (int(n) for n in dims[1:4])
    return np.frombuffer(data, "<" + NIFTI_TYPES[code], x * y * z, start).reshape(z, y, x)


def check(case, strahl):
    """What disagrees, one line each; nothing if all agrees."""
    info, done = strahl.info(case.paths, case.flags)
    message = done.stderr.strip()
    if done.returncode not in (0, 1, 2):
        return [f"ended with {done.returncode}: {message[-300:]}"]
    if case.refused is not None:
        if info is not None:
            return [f"was read, but should be refused ({case.refused})"]
        if case.refused.lower() not in message.lower():
            return [f"refused without saying `{case.refused}`: {message[-300:]}"]
        return []
    if info is None:
        return [f"was refused: {message[-400:]}"]
    problems = []
    if case.affine is not None:
        got = np.array(info["world_from_voxel"])
        worst = affine_difference(got, case.affine)
        if not worst <= 1e-6:
            problems.append(
                f"affine differs by {worst:.3g}:\n{got}\nexpected\n{np.asarray(case.affine)}"
            )
    if not same_number(info["slope"], case.slope) or not same_number(
        info["intercept"], case.intercept
    ):
        problems.append(
            f"slope, intercept {info['slope']}, {info['intercept']}; "
            f"expected {case.slope}, {case.intercept}"
        )
    if case.note is not None and case.note.lower() not in " ".join(info["notes"]).lower():
        problems.append(f"no note with `{case.note}` in {info['notes']}")
    if case.labels is not None:
        # Ids without a name, such as the background, are listed too.
        got = {label["id"]: label["name"] for label in info["labels"] or [] if label["name"]}
        if got != case.labels:
            problems.append(f"labels {got}; expected {case.labels}")
    if case.stored is not None:
        try:
            stored = strahl.stored(case.paths, case.flags)
        except RuntimeError as error:
            return problems + [f"cannot be converted: {error}"]
        problems += differences(stored, case.stored)
    return problems


def differences(got, expected):
    expected = np.ascontiguousarray(expected)
    expected = expected.astype(expected.dtype.newbyteorder("<"))
    if got.shape != expected.shape:
        return [f"shape {got.shape}; expected {expected.shape} (z, y, x)"]
    if got.dtype.str != expected.dtype.str:
        return [f"type {got.dtype}; expected {expected.dtype}"]
    if got.tobytes() == expected.tobytes():
        return []
    wrong = np.flatnonzero(
        got.ravel().view(f"u{got.itemsize}") != expected.ravel().view(f"u{got.itemsize}")
    )
    at = np.unravel_index(wrong[0], got.shape)
    return [
        f"{len(wrong)} of {got.size} voxels differ, the first at (z, y, x) = {tuple(map(int, at))}: "
        f"{got[at]}, expected {expected[at]}"
    ]


def affine_difference(got, expected):
    """The largest difference of an entry, relative to the entry where that is above 1, and to the
    longest voxel edge where that is below."""
    expected = np.asarray(expected, float)
    scale = np.maximum(np.abs(expected), min(1.0, np.abs(expected[:3, :3]).max()))
    return float(np.max(np.abs(got - expected)[:3] / scale[:3]))


def same_number(a, b):
    return abs(a - b) <= 1e-7 * max(abs(a), abs(b))


def samples(dtype, shape=(5, 4, 3), seed=0):
    """Numbers over the whole range of the type, its ends included, as (z, y, x)."""
    rng = np.random.default_rng(seed)
    dtype = np.dtype(dtype)
    if dtype.kind in "ui":
        limits = np.iinfo(dtype)
        data = rng.integers(limits.min, limits.max, shape, dtype.newbyteorder("="), endpoint=True)
        data.flat[:2] = limits.min, limits.max
    else:
        data = rng.normal(0, 1000, shape).astype(dtype.newbyteorder("="))
        data.flat[:4] = np.finfo(dtype).max, np.finfo(dtype).tiny, -0.0, 1.5
    return data.astype(dtype)


def rotation(seed):
    """A random proper rotation."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    if np.linalg.det(q) < 0:
        q[:, 0] = -q[:, 0]
    return q


def affine(directions, spacing, origin):
    out = np.eye(4)
    out[:3, :3] = np.asarray(directions) * np.asarray(spacing)
    out[:3, 3] = origin
    return out


def axis_orders():
    """The 48 ways in which grid axes can lie along world axes."""
    from itertools import permutations, product

    for order in permutations(range(3)):
        for signs in product([1, -1], repeat=3):
            matrix = np.zeros((3, 3))
            for axis, (world, sign) in enumerate(zip(order, signs)):
                matrix[world, axis] = sign
            yield matrix
