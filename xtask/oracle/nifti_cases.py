"""NIfTI-1, NIfTI-2 and Analyze, written and read by nibabel."""

import nibabel as nib
import numpy as np

from case import TYPES, Case, affine, axis_orders, rotation, samples

OBLIQUE = affine(rotation(3), [0.7, 1.3, 2.1], [-31.5, 12.25, 90.0])


def expected(path, image=None):
    """Stored numbers (z, y, x) and affine as nibabel reads them."""
    image = image or nib.load(path)
    stored = np.asanyarray(image.dataobj.get_unscaled())
    while stored.ndim < 3:
        stored = stored[..., None]
    return stored, image.affine


def save(path, data, matrix, version=1, endian="<", codes=(2, 2), change=None):
    single = path.name.endswith((".nii", ".nii.gz"))
    kind = {
        (1, True): nib.Nifti1Image,
        (1, False): nib.Nifti1Pair,
        (2, True): nib.Nifti2Image,
        (2, False): nib.Nifti2Pair,
    }[version, single]
    header = kind.header_class(endianness=endian)
    header.set_data_dtype(data.dtype)
    header.set_xyzt_units("mm")
    image = kind(data, matrix, header)
    image.set_sform(matrix, codes[0])
    image.set_qform(matrix, codes[1], strip_shears=True)
    if change:
        change(image)
    image.to_filename(path)
    return image


def cases(folder):
    yield from layouts(folder)
    yield from places(folder)
    yield from rescales(folder)
    yield from times(folder)
    yield from analyze(folder)


def layouts(folder):
    for version in (1, 2):
        for kind in TYPES:
            for endian in "<>":
                for ending in (".nii", ".nii.gz", ".hdr", ".hdr.gz"):
                    data = samples(kind, seed=version).T.copy()
                    name = f"v{version}-{kind}-{'le' if endian == '<' else 'be'}{ending}"
                    path = folder / name
                    save(path, data, OBLIQUE, version, endian)
                    stored, matrix = expected(path)
                    assert stored.dtype == np.dtype(kind).newbyteorder(endian)
                    yield Case(f"nifti/{name}", [path], stored.T, matrix)
    # The image of a pair can be named too.
    path = folder / "v1-i2-le.img"
    stored, matrix = expected(folder / "v1-i2-le.hdr")
    yield Case("nifti/pair by its .img", [path], stored.T, matrix)


def places(folder):
    data = samples("i2").T.copy()
    for number, directions in enumerate(axis_orders()):
        path = folder / f"order-{number}.nii"
        save(path, data, affine(directions, [0.5, 1.25, 3.0], [1, -2, 3]))
        yield Case(f"nifti/axis order {number}", [path], data.T, expected(path)[1])
    for number in range(8):
        for codes in ((1, 0), (0, 1), (2, 1), (1, 4), (0, 0)):
            path = folder / f"oblique-{number}-{codes[0]}{codes[1]}.nii"

            def other_qform(image, number=number, codes=codes):
                if codes[0] and codes[1]:
                    turned = affine(rotation(50 + number), [0.7, 1.3, 2.1], [9, 8, 7])
                    image.header.set_qform(turned, codes[1])
                    image.header["pixdim"][1:4] = [0.7, 1.3, 2.1]

            matrix = affine(rotation(number), [0.7, 1.3, 2.1], [-50, 20.5, 33])
            if number % 2:
                matrix[:3, 0] *= -1
            save(path, data, matrix, 1 + number % 2, codes=codes, change=other_qform)
            yield Case(
                f"nifti/oblique {number}, sform {codes[0]}, qform {codes[1]}",
                [path],
                data.T,
                expected(path)[1],
            )
    for number in range(4):
        path = folder / f"shear-{number}.nii"
        matrix = OBLIQUE.copy()
        matrix[:3, :3] = matrix[:3, :3] @ (
            np.eye(3) + 0.3 * np.random.default_rng(number).normal(size=(3, 3))
        )
        save(path, data, matrix, codes=(1, 0))
        yield Case(f"nifti/shear {number}", [path], data.T, expected(path)[1])
    for unit, millimetres in (("meter", 1000.0), ("mm", 1.0), ("micron", 0.001), ("unknown", 1.0)):
        path = folder / f"unit-{unit}.nii"

        def in_unit(image, unit=unit):
            image.header.set_xyzt_units(unit)

        save(path, data, OBLIQUE, change=in_unit)
        matrix = expected(path)[1].copy()
        matrix[:3] *= millimetres
        yield Case(f"nifti/unit {unit}", [path], data.T, matrix)
    for qfac in (1, -1, 0):
        path = folder / f"qfac-{qfac}.nii"
        save(path, data, OBLIQUE, codes=(0, 1))
        matrix = expected(path)[1].copy()
        content = bytearray(path.read_bytes())
        content[76:80] = np.float32(qfac).tobytes()
        path.write_bytes(content)
        if qfac:
            matrix = expected(path)[1]
        # Else nibabel refuses to guess; the standard says that 0 means 1.
        yield Case(f"nifti/qfac {qfac}", [path], data.T, matrix)
    path = folder / "extension.nii"

    def with_extension(image):
        image.header.extensions.append(nib.nifti1.Nifti1Extension("comment", b"x" * 3000))

    save(path, data, OBLIQUE, change=with_extension)
    yield Case("nifti/header extension", [path], data.T, expected(path)[1])


def rescales(folder):
    nan, inf = float("nan"), float("inf")
    data = samples("i2").T.copy()
    for version in (1, 2):
        for number, (slope, intercept) in enumerate(
            [(1, 0), (2.5, -1024), (-1, 10), (0, 0), (0, 7), (nan, nan), (nan, 3), (inf, 0), (2, nan)]
        ):
            path = folder / f"slope-{version}-{number}.nii"
            save(path, data, OBLIQUE, version)
            content = bytearray(path.read_bytes())
            at, kind = (112, "<f4") if version == 1 else (176, "<f8")
            numbers = np.array([slope, intercept], kind)
            content[at : at + numbers.nbytes] = numbers.tobytes()
            path.write_bytes(content)
            identity = slope == 0 or not np.isfinite(slope)
            yield Case(
                f"nifti/v{version} slope {slope} intercept {intercept}",
                [path],
                data.T,
                OBLIQUE.astype("f4" if version == 1 else "f8"),
                1.0 if identity else slope,
                0.0 if identity or not np.isfinite(intercept) else intercept,
            )


def times(folder):
    data = samples("u2", (4, 5, 4, 3)).T.copy()
    for ending in (".nii", ".nii.gz", ".hdr"):
        path = folder / f"time{ending}"
        save(path, data, OBLIQUE)
        for k in range(4):
            yield Case(
                f"nifti/time{ending} {k}",
                [path],
                data[..., k].T,
                OBLIQUE.astype("f4"),
                flags=["--time", k],
            )
        yield Case(f"nifti/time{ending} 4", [path], flags=["--time", 4], refused="time")
    for shape in ((3, 4), (3, 4, 1), (3, 4, 5, 1), (3, 4, 5, 1, 1)):
        path = folder / f"shape-{len(shape)}-{shape[-1]}.nii"
        data = samples("u1", shape[::-1]).T.copy()
        save(path, data, OBLIQUE)
        yield Case(
            f"nifti/shape {shape}",
            [path],
            data.reshape((shape + (1, 1, 1))[:3], order="F").T,
            OBLIQUE.astype("f4"),
        )


def analyze(folder):
    for kind in ("u1", "i2", "i4", "f4"):
        for endian in "<>":
            data = samples(kind).T.copy()
            header = nib.Spm99AnalyzeHeader(endianness=endian)
            header.set_data_dtype(kind)
            matrix = np.diag([-1.5, 2, 3, 1.0])
            matrix[:3, 3] = [4.5, -6, -9]
            path = folder / f"analyze-{kind}-{'le' if endian == '<' else 'be'}.img"
            image = nib.Spm99AnalyzeImage(data, matrix, header)
            image.to_filename(path)
            path.with_suffix(".mat").unlink(missing_ok=True)
            image = nib.load(path)
            yield Case(
                f"nifti/{path.name}",
                [path.with_suffix(".hdr")],
                np.asanyarray(image.dataobj.get_unscaled()).T,
                image.affine,
            )
