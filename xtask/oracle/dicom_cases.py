"""DICOM series and multi-frame files, written by pydicom, packed by pydicom and GDCM."""

import random

import gdcm
import numpy as np
import pydicom
from pydicom import uid
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.sequence import Sequence

from case import LPS_FROM_RAS, Case, affine, rotation

CT = "1.2.840.10008.5.1.4.1.1.2"
ENHANCED_CT = "1.2.840.10008.5.1.4.1.1.2.1"

# What GDCM packs an uncompressed file into; all of these are lossless.
PACKED = {
    "rle": gdcm.TransferSyntax.RLELossless,
    "jpeg-lossless": gdcm.TransferSyntax.JPEGLosslessProcess14,
    "jpeg-lossless-sv1": gdcm.TransferSyntax.JPEGLosslessProcess14_1,
    "jpeg-ls": gdcm.TransferSyntax.JPEGLSLossless,
    "jpeg-2000": gdcm.TransferSyntax.JPEG2000Lossless,
}

PLAIN = {
    "implicit": uid.ImplicitVRLittleEndian,
    "explicit": uid.ExplicitVRLittleEndian,
    "big-endian": uid.ExplicitVRBigEndian,
    "deflated": uid.DeflatedExplicitVRLittleEndian,
}

# name: bits allocated, bits stored, signed
PIXELS = {
    "u8": (8, 8, False),
    "u12": (16, 12, False),
    "i12": (16, 12, True),
    "u16": (16, 16, False),
    "i16": (16, 16, True),
}

ROWS, COLUMNS = 16, 24


def pictures(pixels, slices=6, seed=0):
    """Smooth enough to be packed as scans are, and with the ends of the range in it."""
    allocated, stored, signed = PIXELS[pixels]
    low, high = (-(1 << stored - 1), (1 << stored - 1) - 1) if signed else (0, (1 << stored) - 1)
    rng = np.random.default_rng(seed)
    z, y, x = np.mgrid[:slices, :ROWS, :COLUMNS]
    wave = np.sin(x / 5.0) * np.cos(y / 3.0 + z) + rng.normal(0, 0.05, x.shape)
    data = np.clip(low + (wave + 1) / 2 * (high - low), low, high)
    data[:, 0, 0], data[:, -1, -1] = low, high
    return np.round(data).astype(f"{'i' if signed else 'u'}{allocated // 8}")


def slice_file(picture, pixels, series, number, position, orientation, **fields):
    allocated, stored, signed = PIXELS[pixels]
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = CT
    meta.MediaStorageSOPInstanceUID = f"{series}.{number}"
    meta.TransferSyntaxUID = uid.ExplicitVRLittleEndian
    file = Dataset()
    file.file_meta = meta
    file.SOPClassUID = CT
    file.SOPInstanceUID = meta.MediaStorageSOPInstanceUID
    file.StudyInstanceUID = "1.2.826.0.1.3680043.8.498.1"
    file.SeriesInstanceUID = series
    file.FrameOfReferenceUID = "1.2.826.0.1.3680043.8.498.2"
    file.Modality = "CT"
    file.PatientName = "Nobody"
    file.PatientID = "0"
    file.SeriesNumber = 1
    file.InstanceNumber = number
    file.ImageType = ["ORIGINAL", "PRIMARY", "AXIAL"]
    file.Rows, file.Columns = picture.shape
    file.PixelSpacing = [1.3, 0.7]
    file.SliceThickness = 2.5
    file.ImageOrientationPatient = [float(f"{v:.12g}") for v in orientation]
    file.ImagePositionPatient = [float(f"{v:.10g}") for v in position]
    file.SamplesPerPixel = 1
    file.PhotometricInterpretation = "MONOCHROME2"
    file.BitsAllocated, file.BitsStored, file.HighBit = allocated, stored, stored - 1
    file.PixelRepresentation = int(signed)
    file.RescaleSlope, file.RescaleIntercept = 1, -1024
    file.RescaleType = "HU"
    file.PixelData = picture.tobytes()
    file["PixelData"].VR = "OB" if allocated == 8 else "OW"
    for name, value in fields.items():
        if value is None:
            delattr(file, name)
        else:
            setattr(file, name, value)
    return file


def save(file, path, syntax=uid.ExplicitVRLittleEndian):
    big = syntax == uid.ExplicitVRBigEndian
    if big and file.BitsAllocated == 16:
        file.PixelData = np.frombuffer(file.PixelData, "<u2").astype(">u2").tobytes()
    file.file_meta.TransferSyntaxUID = syntax
    file.save_as(path, enforce_file_format=True)


def pack(path, syntax):
    reader = gdcm.ImageReader()
    reader.SetFileName(str(path))
    assert reader.Read(), path
    change = gdcm.ImageChangeTransferSyntax()
    change.SetTransferSyntax(gdcm.TransferSyntax(syntax))
    change.SetInput(reader.GetImage())
    assert change.Change(), f"GDCM cannot pack {path}"
    writer = gdcm.ImageWriter()
    writer.SetFileName(str(path))
    writer.SetFile(reader.GetFile())
    writer.SetImage(change.GetOutput())
    assert writer.Write(), path


def geometry(directions, step, origin, slices):
    """Orientation, positions (LPS) and RAS affine of a series whose slices are `step` (mm, LPS) apart."""
    orientation = [*directions[:, 0], *directions[:, 1]]
    positions = [np.asarray(origin) + k * np.asarray(step) for k in range(slices)]
    matrix = np.eye(4)
    matrix[:3, 0] = directions[:, 0] * 0.7
    matrix[:3, 1] = directions[:, 1] * 1.3
    matrix[:3, 2] = step
    matrix[:3, 3] = origin
    return orientation, positions, LPS_FROM_RAS @ matrix


def series(folder, name, pixels="i16", syntax="explicit", directions=None, step=None, keep=None, seed=0, **fields):
    """Writes a series under shuffled names; its folder, its samples and its affine."""
    directions = np.eye(3) if directions is None else directions
    step = directions[:, 2] * 2.5 if step is None else step
    data = pictures(pixels, seed=seed)
    orientation, positions, matrix = geometry(directions, step, [-100.5, -80.25, 40.0], len(data))
    place = folder / name
    place.mkdir(exist_ok=True)
    for old in place.iterdir():
        old.unlink()
    numbers = list(range(len(data)))
    random.Random(name).shuffle(numbers)
    series_uid = f"1.2.826.0.1.3680043.8.498.{abs(hash_of(name)) % 10**9}"
    for k in keep if keep is not None else range(len(data)):
        # Neither the name nor the instance number follows the place.
        file = slice_file(
            data[k], pixels, series_uid, numbers[k] + 1, positions[k], orientation, **fields
        )
        path = place / f"IM{numbers[k]:04}"
        save(file, path, PLAIN.get(syntax, uid.ExplicitVRLittleEndian))
        if syntax in PACKED:
            pack(path, PACKED[syntax])
    return place, data, matrix


def hash_of(text):
    return sum((i + 1) * ord(c) * 7919 for i, c in enumerate(text))


def read_back(place, order):
    """What pydicom decodes, in the order of the slices' places."""
    files = [pydicom.dcmread(path) for path in place.iterdir()]
    files.sort(key=lambda file: np.dot(order, np.array(file.ImagePositionPatient, float)))
    return np.stack([file.pixel_array for file in files])


def cases(folder):
    up = np.array([0, 0, 1.0])
    for pixels in PIXELS:
        for syntax in [*PLAIN, *PACKED]:
            place, data, matrix = series(folder, f"{pixels}-{syntax}", pixels, syntax)
            decoded = read_back(place, up)
            if not np.array_equal(decoded, data):
                # Known: GDCM writes signed samples of fewer bits than allocated so that other
                # decoders lose the sign; such a file says nothing about a reader.
                if PIXELS[pixels] == (16, 12, True):
                    yield Case(f"dicom/{place.name} (witnesses disagree)", [place], None, matrix, 1, -1024)
                    continue
                raise AssertionError(f"pydicom reads {place} differently from what was written")
            yield Case(f"dicom/{place.name}", [place], data, matrix, 1, -1024)

    for number in range(6):
        directions = rotation(20 + number)
        place, data, matrix = series(folder, f"oblique-{number}", directions=directions)
        yield Case(f"dicom/oblique {number}", [place], data, matrix, 1, -1024)

    # Slices that follow each other against the normal are sorted along it.
    place, data, matrix = series(folder, "downward", step=[0, 0, -2.5])
    turned = matrix.copy()
    turned[:3, 3] += 5 * matrix[:3, 2]
    turned[:3, 2] *= -1
    yield Case("dicom/downward", [place], data[::-1], turned, 1, -1024)

    place, data, matrix = series(folder, "tilt", step=[0, 0.9, 2.5])
    yield Case("dicom/gantry tilt", [place], data, matrix, 1, -1024)

    place, data, matrix = series(folder, "missing", keep=[0, 1, 2, 4, 5])
    yield Case("dicom/missing slice", [place], refused="--allow-gaps")
    yield Case(
        "dicom/missing slice, resampled", [place], None, matrix, 1, -1024, flags=["--allow-gaps"]
    )

    place, data, matrix = series(folder, "decimal", RescaleSlope="0.5", RescaleIntercept="-10.25")
    yield Case("dicom/slope", [place], data, matrix, 0.5, -10.25)
    place, data, matrix = series(
        folder, "no-rescale", RescaleSlope=None, RescaleIntercept=None, RescaleType=None
    )
    yield Case("dicom/no rescale", [place], data, matrix)

    # A localiser of another size in the same folder, and one in the same series.
    for same in (False, True):
        name = f"localiser-{'same' if same else 'other'}"
        place, data, matrix = series(folder, name)
        first = pydicom.dcmread(next(place.iterdir()))
        other = slice_file(
            np.zeros((40, 40), "i2"),
            "i16",
            first.SeriesInstanceUID if same else "1.2.826.0.1.3680043.8.498.77",
            99,
            [0, 0, 0],
            [1, 0, 0, 0, 0, -1],
            ImageType=["ORIGINAL", "PRIMARY", "LOCALIZER"],
            SeriesNumber=1 if same else 7,
        )
        save(other, place / "AAA")
        yield Case(f"dicom/{name}", [place], data, matrix, 1, -1024, note="left out")

    # Two series in one folder.
    place, data, matrix = series(folder, "two-series", seed=1)
    second, data_2, _ = series(folder, "two-series-second", seed=2, SeriesNumber=2)
    for path in second.iterdir():
        path.rename(place / f"B{path.name}")
    yield Case("dicom/two series", [place], refused="--series")
    yield Case("dicom/two series, 1", [place], data, matrix, 1, -1024, flags=["--series", 1])
    yield Case("dicom/two series, 2", [place], data_2, matrix, 1, -1024, flags=["--series", 2])

    # The slices as a list of files.
    place, data, matrix = series(folder, "list")
    yield Case("dicom/list of files", sorted(place.iterdir()), data, matrix, 1, -1024)

    yield from multi_frame(folder)


def multi_frame(folder):
    directions = rotation(31)
    for pixels in ("u8", "u12", "i16"):
        for syntax in ("explicit", "implicit", "rle", "jpeg-ls", "jpeg-2000", "jpeg-lossless-sv1"):
            data = pictures(pixels, seed=5)
            orientation, positions, matrix = geometry(
                directions, directions[:, 2] * 2.5, [-10.5, 20.25, 7.0], len(data)
            )
            order = list(range(len(data)))
            random.Random(1).shuffle(order)
            file = slice_file(
                data[0], pixels, "1.2.826.0.1.3680043.8.498.900", 1, positions[0], orientation,
                ImagePositionPatient=None, ImageOrientationPatient=None, PixelSpacing=None,
                SliceThickness=None, RescaleSlope=None, RescaleIntercept=None, RescaleType=None,
            )  # fmt: skip
            file.SOPClassUID = file.file_meta.MediaStorageSOPClassUID = ENHANCED_CT
            file.NumberOfFrames = len(data)
            file.PixelData = data[order].tobytes()

            measures, placement, rescale, shared = Dataset(), Dataset(), Dataset(), Dataset()
            measures.PixelSpacing, measures.SliceThickness = [1.3, 0.7], 2.5
            placement.ImageOrientationPatient = [float(f"{v:.12g}") for v in orientation]
            rescale.RescaleIntercept, rescale.RescaleSlope, rescale.RescaleType = -1024, 1, "HU"
            shared.PixelMeasuresSequence = Sequence([measures])
            shared.PlaneOrientationSequence = Sequence([placement])
            shared.PixelValueTransformationSequence = Sequence([rescale])
            file.SharedFunctionalGroupsSequence = Sequence([shared])
            frames = []
            for k in order:
                frame, position = Dataset(), Dataset()
                position.ImagePositionPatient = [float(f"{v:.10g}") for v in positions[k]]
                frame.PlanePositionSequence = Sequence([position])
                frames.append(frame)
            file.PerFrameFunctionalGroupsSequence = Sequence(frames)
            path = folder / f"enhanced-{pixels}-{syntax}.dcm"
            save(file, path, PLAIN.get(syntax, uid.ExplicitVRLittleEndian))
            if syntax in PACKED:
                pack(path, PACKED[syntax])
                # GDCM writes places and spacings of its own; only its pixels are wanted.
                packed = pydicom.dcmread(path)
                file.PixelData = packed.PixelData
                file["PixelData"].VR = "OB"
                file["PixelData"].is_undefined_length = True
                save(file, path, packed.file_meta.TransferSyntaxUID)
            decoded = pydicom.dcmread(path).pixel_array
            assert np.array_equal(decoded, data[order]), path
            yield Case(f"dicom/{path.name}", [path], data, matrix, 1, -1024)
