"""Formats with few variants, number types that are narrowed, and Siemens mosaics: written by nibabel, NumPy, pynrrd,
SimpleITK, mrcfile and pydicom."""

import struct

import mrcfile
import nibabel as nib
import nrrd
import numpy as np
import pydicom
import SimpleITK as sitk
from nibabel.nicom.dicomwrappers import wrapper_from_data

from case import LPS_FROM_RAS, Case, affine, rotation, samples
from dicom_cases import save, slice_file

OBLIQUE = affine(rotation(5), [0.7, 1.3, 2.1], [-31.5, 12.25, 90.0])


def cases(folder):
    yield from freesurfer(folder)
    yield from wide_numbers(folder)
    yield from vtk(folder)
    yield from maps(folder)
    yield from archives(folder)
    yield from mosaics(folder)


def freesurfer(folder):
    for kind in ("u1", "i2", "i4", "f4"):
        for ending in (".mgh", ".mgz"):
            data = samples(kind).T.copy()
            path = folder / f"{kind}{ending}"
            nib.save(nib.MGHImage(data, OBLIQUE), path)
            read = nib.load(path)
            assert np.array_equal(np.asanyarray(read.dataobj), data)
            yield Case(f"mgh/{path.name}", [path], data.T, read.affine)
    movie = samples("i2", (3, 5, 4, 3)).T.copy()
    path = folder / "movie.mgz"
    nib.save(nib.MGHImage(movie, OBLIQUE), path)
    for k in range(3):
        yield Case(f"mgh/time {k}", [path], movie[..., k].T, flags=["--time", k])


def wide_numbers(folder):
    small = (np.arange(60) - 10).reshape(5, 4, 3)
    large = (np.arange(60, dtype="u8") + 2**31).reshape(5, 4, 3)
    for name, data, kept in (("i8", small.astype("i8"), "<i4"), ("u8", large, "<u4")):
        expected = data.astype(kept)
        path = folder / f"{name}.npy"
        np.save(path, data)
        yield Case(f"wide/{path.name}", [path], expected, note="64-bit")
        path = folder / f"{name}.nii.gz"
        nib.save(nib.Nifti1Image(data.T, OBLIQUE, dtype=data.dtype), path)
        yield Case(f"wide/{path.name}", [path], expected, OBLIQUE, note="64-bit")
        path = folder / f"{name}.nrrd"
        nrrd.write(str(path), data.T)
        yield Case(f"wide/{path.name}", [path], expected, note="64-bit")
        for ending in (".mha", ".nrrd"):
            path = folder / f"itk-{name}{ending}"
            sitk.WriteImage(sitk.GetImageFromArray(data), str(path))
            yield Case(f"wide/{path.name}", [path], expected, note="64-bit")
    half = samples("f4").clip(-60000, 60000).astype("f2")
    path = folder / "half.npy"
    np.save(path, half)
    yield Case("wide/half.npy", [path], half.astype("<f4"), note="half floats")


def vtk(folder):
    for kind in ("u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"):
        image = sitk.GetImageFromArray(samples(kind))
        image.SetSpacing([0.5, 0.7, 2.0])
        image.SetOrigin([10.0, -20.0, 30.0])
        path = folder / f"{kind}.vtk"
        sitk.WriteImage(image, str(path))
        place = affine(np.diag([-1.0, -1.0, 1.0]), [0.5, 0.7, 2.0], [-10.0, 20.0, 30.0])
        yield Case(f"vtk/{path.name}", [path], samples(kind), place)


def maps(folder):
    for kind in ("i1", "i2", "u2", "f4"):
        data = samples(kind)
        path = folder / f"{kind}.mrc"
        with mrcfile.new(path, overwrite=True) as file:
            file.set_data(data)
            file.voxel_size = (1.5, 2.5, 4.0)
        place = affine(np.diag([-1.0, -1.0, 1.0]), np.array([1.5, 2.5, 4.0]) * 1e-7, [0, 0, 0])
        yield Case(f"mrc/{path.name}", [path], data, place)


def archives(folder):
    data = samples("i2")
    for write in (np.savez, np.savez_compressed):
        path = folder / f"{write.__name__}.npz"
        write(path, scan=data, affine=np.eye(4))
        yield Case(f"npz/{path.name}", [path], data, note="scan.npy is one of 2")


def csa(fields):
    """A CSA header of version 2, as nibabel reads it."""
    out = b"SV10\4\3\2\1" + struct.pack("<II", len(fields), 77)
    for name, kind, values in fields:
        out += struct.pack("<64si4siii", name.encode(), len(values), kind, 0, 6, 77)
        for k in range(6):
            text = values[k].encode() + b"\0" if k < len(values) else b""
            out += struct.pack("<4i", len(text), len(text), 77, len(text))
            out += text + b"\0" * (-len(text) % 4)
    return out


def mosaics(folder):
    for seed, slices in ((1, 4), (2, 7)):
        across = int(np.ceil(np.sqrt(slices)))
        edge = 6
        data = samples("i2", (slices, edge, edge), seed)
        picture = np.zeros((across * edge, across * edge), "i2")
        for k in range(slices):
            y, x = k // across * edge, k % across * edge
            picture[y : y + edge, x : x + edge] = data[k]
        axes = rotation(seed)
        series = f"1.2.826.0.1.3680043.8.498.9.{seed}"
        orientation = [*axes[:, 0], *axes[:, 1]]
        file = slice_file(picture, "i16", series, 1, [12.5, -7.25, 31.0], orientation)
        file.Modality, file.Manufacturer = "MR", "SIEMENS"
        file.ImageType = ["ORIGINAL", "PRIMARY", "M", "ND", "MOSAIC"]
        file.SOPClassUID = pydicom.uid.MRImageStorage
        file.SpacingBetweenSlices = 3.5
        private = file.private_block(0x29, "SIEMENS CSA HEADER", create=True)
        header = csa(
            [
                ("NumberOfImagesInMosaic", b"US\0\0", [str(slices)]),
                ("AcquisitionMatrixText", b"SH\0\0", [f"{edge}p*{edge}"]),
                ("SliceNormalVector", b"FD\0\0", [f"{n:.16f}" for n in axes[:, 2]]),
            ]
        )
        private.add_new(0x10, "OB", header)
        path = folder / f"mosaic-{seed}.dcm"
        save(file, path)
        witness = wrapper_from_data(pydicom.dcmread(path))
        # nibabel counts rows first.
        assert np.array_equal(witness.get_unscaled_data(), data.transpose(1, 2, 0))
        place = LPS_FROM_RAS @ witness.affine[:, [1, 0, 2, 3]]
        yield Case(f"mosaic/{path.name}", [path], data, place, intercept=-1024)
