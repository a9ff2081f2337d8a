"""The other way round: what Strahl writes, read by nibabel, pynrrd, SimpleITK and NumPy."""

import nibabel as nib
import nrrd
import numpy as np
import SimpleITK as sitk

from case import TYPES, affine, affine_difference, rotation, samples
from nifti_cases import save
from nrrd_cases import SPACES, sitk_affine


def checks(folder, strahl):
    """Yields name, problems."""
    yield from components(folder, strahl)
    matrix = affine(rotation(6), [0.7, 1.3, 2.1], [-31.5, 12.25, 90.0])
    for kind in TYPES:
        for slope, intercept in ((1, 0), (2, -1024), (0.5, 0.25)):
            if kind in ("f8", "u4", "i4") and slope != 1:
                continue
            data = samples(kind)
            if kind[0] == "f":
                data = np.round(np.clip(data, -1e6, 1e6)).astype(kind)
            source = folder / f"{kind}-{slope}.nii"

            def rescaled(image, slope=slope, intercept=intercept):
                image.header.set_slope_inter(slope, intercept)

            # Version 2 keeps the affine in 64 bits.
            save(source, data.T.copy(), matrix, version=2, codes=(1, 0))
            content = bytearray(source.read_bytes())
            content[176:192] = np.array([slope, intercept], "<f8").tobytes()
            source.write_bytes(content)
            values = data.astype("f8") * slope + intercept
            for ending, read in READERS.items():
                out = folder / f"out-{kind}-{slope}{ending}"
                done = strahl.run("convert", source, out, "--quiet")
                name = f"write/{out.name}"
                if done.returncode != 0:
                    yield name, [done.stderr.strip()]
                    continue
                got, got_matrix = read(out)
                problems = []
                if got.shape != values.shape or not np.array_equal(got.astype("f8"), values):
                    problems.append(f"values differ: {got.ravel()[:4]}, expected {values.ravel()[:4]}")
                if slope == 1 and got.dtype != data.dtype:
                    problems.append(f"type {got.dtype}; expected {data.dtype}")
                if got_matrix is not None:
                    # NIfTI-1 has room for 32 bits.
                    worst = affine_difference(got_matrix, matrix)
                    if not worst <= 1e-6:
                        problems.append(f"affine differs by {worst:.3g}:\n{got_matrix}\n{matrix}")
                yield name, problems


def components(folder, strahl):
    """Colors and vectors, which have to come out as such."""
    matrix = np.diag([0.7, 1.3, 2.1, 1.0])
    rgb = samples("u1", (5, 4, 3, 3))
    colors = np.ascontiguousarray(rgb.transpose(2, 1, 0, 3)).view([(c, "u1") for c in "RGB"])[..., 0]
    save(folder / "rgb.nii", colors, matrix)
    vectors = samples("f4", (6, 5, 4, 3))
    save(folder / "vector.nii", vectors.T[:, :, :, None], matrix)
    for name, expected in (("rgb", rgb), ("vector", np.moveaxis(vectors, 0, -1))):
        for ending in (".nii.gz", ".nrrd", ".mha", ".mhd"):
            out = folder / f"{name}{ending}"
            done = strahl.run("convert", folder / f"{name}.nii", out, "--quiet")
            if done.returncode != 0:
                yield f"write/components {out.name}", [done.stderr.strip()]
                continue
            got = sitk.GetArrayFromImage(sitk.ReadImage(str(out)))
            problems = []
            if got.dtype != expected.dtype or not np.array_equal(got, expected):
                problems.append(f"{got.shape} {got.dtype} differ from {expected.shape}")
            if name == "rgb" and ending == ".nii.gz":
                if nib.load(out).header["datatype"] != 128:
                    problems.append("not RGB24")
            if ending == ".nrrd":
                kind = nrrd.read_header(str(out))["kinds"][0]
                if kind != {"rgb": "RGB-color", "vector": "vector"}[name]:
                    problems.append(f"the kind {kind}")
            yield f"write/components {out.name}", problems


def read_nifti(path):
    image = nib.load(path)
    scaled = image.dataobj.slope != 1 or image.dataobj.inter != 0
    data = np.asanyarray(image.dataobj if scaled else image.dataobj.get_unscaled())
    return data.T, image.affine


def read_nrrd(path):
    data, header = nrrd.read(str(path))
    matrix = np.eye(4)
    matrix[:3, :3] = np.array(header["space directions"]).T
    matrix[:3, 3] = header["space origin"]
    return data.T, SPACES[header["space"]] @ matrix


def read_sitk(path):
    image = sitk.ReadImage(str(path))
    return sitk.GetArrayFromImage(image), sitk_affine(image)


def read_npy(path):
    return np.load(path), None


READERS = {
    ".nii": read_nifti,
    ".nii.gz": read_nifti,
    ".nrrd": read_nrrd,
    ".mha": read_sitk,
    ".mhd": read_sitk,
    ".npy": read_npy,
}
