"""NRRD, written by pynrrd; places as SimpleITK reads them."""

import nrrd
import numpy as np
import SimpleITK as sitk

from case import LPS_FROM_RAS, TYPES, Case, affine, axis_orders, rotation, samples

NAMES = {
    "u1": "uint8", "i1": "int8", "u2": "uint16", "i2": "int16",
    "u4": "uint32", "i4": "int32", "f4": "float", "f8": "double",
}  # fmt: skip

SPACES = {
    "left-posterior-superior": np.diag([-1, -1, 1, 1]),
    "LPS": np.diag([-1, -1, 1, 1]),
    "right-anterior-superior": np.eye(4),
    "RAS": np.eye(4),
    "left-anterior-superior": np.diag([-1, 1, 1, 1]),
    "LAS": np.diag([-1, 1, 1, 1]),
}


def sitk_affine(image):
    """RAS affine of what SimpleITK read."""
    directions = np.array(image.GetDirection()).reshape(3, 3)
    return LPS_FROM_RAS @ affine(directions, image.GetSpacing(), image.GetOrigin())


def header_of(matrix, space="LPS", **fields):
    return {
        "space": space,
        "space directions": matrix[:3, :3].T,
        "space origin": matrix[:3, 3],
        **fields,
    }


def cases(folder):
    lps = affine(rotation(4), [0.7, 1.3, 2.1], [-31.5, 12.25, 90.0])
    ras = LPS_FROM_RAS @ lps
    for kind in TYPES:
        for encoding in ("raw", "gzip", "bzip2", "ascii"):
            for endian in "<>":
                for detached in (False, True):
                    name = f"{kind}-{encoding}-{'le' if endian == '<' else 'be'}"
                    path = folder / (name + (".nhdr" if detached else ".nrrd"))
                    data = samples(np.dtype(kind).newbyteorder(endian)).T.copy()
                    if encoding == "ascii" and data.dtype.kind == "f":
                        data = np.round(np.nan_to_num(data, posinf=0) % 1000, 1).astype(data.dtype)
                    nrrd.write(str(path), data, header_of(lps, encoding=encoding), detached)
                    stored, _ = nrrd.read(str(path))
                    yield Case(f"nrrd/{path.name}", [path], stored.T, ras)

    data = samples("i2").T.copy()
    for space, ras_from_space in SPACES.items():
        for number, directions in enumerate(list(axis_orders())[::5] + [rotation(9)]):
            path = folder / f"space-{space}-{number}.nrrd"
            matrix = affine(directions, [0.5, 1.25, 3.0], [1, -2, 3])
            nrrd.write(str(path), data, header_of(matrix, space))
            expected = ras_from_space @ matrix
            witness = sitk_affine(sitk.ReadImage(str(path)))
            if np.linalg.det(np.array(sitk.ReadImage(str(path)).GetDirection()).reshape(3, 3)) > 0:
                assert np.allclose(expected, witness), (space, number, expected, witness)
            yield Case(f"nrrd/space {space} {number}", [path], data.T, expected)

    # Without a space: spacings alone.
    path = folder / "spacings.nrrd"
    nrrd.write(str(path), data, {"spacings": [0.5, 1.25, 3.0]})
    yield Case("nrrd/spacings", [path], data.T, sitk_affine(sitk.ReadImage(str(path))))

    # A list axis, at the front and at the end.
    movie = samples("u2", (4, 5, 4, 3))
    for front in (True, False):
        path = folder / f"list-{'first' if front else 'last'}.nrrd"
        none = np.full((1, 3), np.nan)
        rows = lps[:3, :3].T
        directions = np.vstack([none, rows] if front else [rows, none])
        axes = movie.transpose(0, 3, 2, 1) if front else movie.T
        kinds = ["list"] + ["domain"] * 3 if front else ["domain"] * 3 + ["list"]
        nrrd.write(
            str(path),
            np.asfortranarray(axes),
            header_of(lps, kinds=kinds) | {"space directions": directions},
        )
        back, _ = nrrd.read(str(path))
        for k in range(4):
            stored = back[k] if front else back[..., k]
            yield Case(f"nrrd/{path.name} {k}", [path], stored.T, ras, flags=["--time", k])

    # Several data files, skipped bytes and lines: written by hand, read by pynrrd.
    flat = samples("i2")
    for k, slice_ in enumerate(flat):
        (folder / f"part{k + 1}.raw").write_bytes(slice_.tobytes())
    sizes = "sizes: 3 4 5"
    start = f"NRRD0004\ntype: short\ndimension: 3\n{sizes}\nendian: little\nencoding: raw\n"
    by_list = "data file: LIST\n" + "".join(f"part{k}.raw\n" for k in range(1, 6))
    by_pattern = "data file: part%d.raw 1 5 1\n"
    for name, text in (("list", by_list), ("pattern", by_pattern)):
        path = folder / f"files-{name}.nhdr"
        path.write_text(start + text)
        # pynrrd does not know these; SimpleITK does.
        stored = sitk.GetArrayFromImage(sitk.ReadImage(str(path)))
        yield Case(f"nrrd/files by {name}", [path], stored)
    for name, junk, text in (
        ("byte skip", b"12345", "byte skip: 5\n"),
        ("byte skip -1", b"x" * 77, "byte skip: -1\n"),
        ("line skip", b"one\ntwo\n", "line skip: 2\n"),
        ("line and byte skip", b"one\ntwo\n123", "line skip: 2\nbyte skip: 3\n"),
    ):
        (folder / f"{name}.raw").write_bytes(junk + flat.tobytes())
        path = folder / f"{name}.nhdr"
        path.write_text(start + text + f"data file: {name}.raw\n")
        stored, _ = nrrd.read(str(path))
        yield Case(f"nrrd/{name}", [path], stored.T)

    # Segment names as 3D Slicer writes them.
    ids = samples("u1") % 3
    path = folder / "objects.seg.nrrd"
    segments = {}
    for number, name in ((0, "liver"), (1, "left kidney")):
        segments |= {
            f"Segment{number}_ID": f"Segment_{number + 1}",
            f"Segment{number}_Name": name,
            f"Segment{number}_LabelValue": str(number + 1),
            f"Segment{number}_Layer": "0",
            f"Segment{number}_Color": "0.5 0.25 1",
        }
    nrrd.write(str(path), ids.T.copy(), header_of(lps, **segments))
    yield Case("nrrd/segment names", [path], ids, ras, labels={1: "liver", 2: "left kidney"})
