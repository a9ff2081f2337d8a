"""Colors, palettes, segmentations and structure sets: written by pydicom and tifffile, with pydicom, Pillow and NumPy as
witnesses."""

import itertools

import numpy as np
import pydicom
import tifffile
from PIL import Image
from pydicom import uid
from pydicom.dataset import Dataset
from pydicom.pixels import apply_color_lut, convert_color_space, pack_bits
from pydicom.sequence import Sequence

from case import LPS_FROM_RAS, Case
from dicom_cases import PACKED, PLAIN, pack, save, slice_file

ROWS, COLUMNS = 48, 64
ORIGIN = [12.5, -7.25, 31.0]
AXIAL = [1, 0, 0, 0, 1, 0]


def cases(folder):
    yield from colors(folder)
    yield from palettes(folder)
    yield from segmentations(folder)
    yield from structure_sets(folder)


def components(name, path, pixels):
    """One case for each number of a voxel; `pixels` has the shape (z, y, x, number)."""
    for k in range(pixels.shape[-1]):
        stored = np.ascontiguousarray(pixels[..., k])
        yield Case(f"color/{name}, {k}", [path], stored, flags=["--component", k])


# A file alone stands for its whole series, so each has its own.
SERIES = itertools.count(1)


def color_file(photometric, planar, pixels):
    file = slice_file(
        pixels[..., 0], "u8", f"1.2.826.0.1.3680043.8.498.20.{next(SERIES)}", 1, ORIGIN, AXIAL,
        SamplesPerPixel=3, PhotometricInterpretation=photometric, PlanarConfiguration=planar,
        RescaleSlope=None, RescaleIntercept=None, RescaleType=None,
    )  # fmt: skip
    file.PixelData = (pixels.transpose(2, 0, 1) if planar else pixels).tobytes()
    file["PixelData"].VR = "OB"
    return file


def colors(folder):
    rng = np.random.default_rng(20)
    pixels = rng.integers(0, 256, (ROWS, COLUMNS, 3), "u1")
    for photometric in ("RGB", "YBR_FULL"):
        rgb = pixels if photometric == "RGB" else convert_color_space(pixels, "YBR_FULL", "RGB")
        for planar in (0, 1):
            for name, syntax in PLAIN.items():
                path = folder / f"{photometric}-{planar}-{name}.dcm"
                save(color_file(photometric, planar, pixels), path, syntax)
                witness = pydicom.dcmread(path).pixel_array
                assert np.array_equal(witness, rgb)
                yield from components(path.name, path, rgb[None])
            if planar:
                continue  # pydicom packs planes as if they were pixels
            path = folder / f"{photometric}-{planar}-rle.dcm"
            file = color_file(photometric, planar, pixels)
            file.compress(uid.RLELossless, generate_instance_uid=False)
            file.save_as(path, enforce_file_format=True)
            yield from components(path.name, path, rgb[None])
    # GDCM and OpenJPEG in one process end it when GDCM packs colors in JPEG 2000.
    path = folder / "RGB-jpeg-lossless.dcm"
    save(color_file("RGB", 0, pixels), path)
    pack(path, PACKED["jpeg-lossless"])
    assert np.array_equal(pydicom.dcmread(path).pixel_array, pixels)
    yield from components(path.name, path, pixels[None])
    for photometric in ("RGB", "YBR_RCT"):
        path = folder / f"{photometric}-jpeg-2000.dcm"
        file = color_file("RGB", 0, pixels)
        file.PhotometricInterpretation = photometric
        file.compress(uid.JPEG2000Lossless, generate_instance_uid=False)
        file.save_as(path, enforce_file_format=True)
        assert np.array_equal(pydicom.dcmread(path).pixel_array, pixels)
        yield from components(path.name, path, pixels[None])


def palettes(folder):
    rng = np.random.default_rng(21)
    indices = rng.integers(0, 256, (ROWS, COLUMNS), "u1")
    for bits in (8, 16):
        tables = rng.integers(0, 1 << bits, (3, 256)).astype(f"u{bits // 8}")
        file = slice_file(
            indices, "u8", f"1.2.826.0.1.3680043.8.498.21.{bits}", 1, ORIGIN, AXIAL,
            PhotometricInterpretation="PALETTE COLOR",
            RescaleSlope=None, RescaleIntercept=None, RescaleType=None,
        )  # fmt: skip
        for name, table in zip(("Red", "Green", "Blue"), tables):
            setattr(file, f"{name}PaletteColorLookupTableDescriptor", [256, 0, bits])
            setattr(file, f"{name}PaletteColorLookupTableData", table.tobytes())
            file[f"{name}PaletteColorLookupTableData"].VR = "OW"
            file[f"{name}PaletteColorLookupTableDescriptor"].VR = "US"
        path = folder / f"palette-{bits}.dcm"
        save(file, path)
        rgb = apply_color_lut(indices, pydicom.dcmread(path))
        yield from components(path.name, path, rgb[None])
    map_of_tiff = rng.integers(0, 256, (3, 256)).astype("u2") * 257
    path = folder / "palette.tif"
    tifffile.imwrite(path, indices, photometric="palette", colormap=map_of_tiff)
    rgb = np.asarray(Image.open(path).convert("RGB"))
    yield from components(path.name, path, rgb[None])


def segmentations(folder):
    """Frames of 35 bits, so that most begin within a byte."""
    rng = np.random.default_rng(22)
    rows, columns, frames = 5, 7, 4
    masks = rng.integers(0, 2, (frames, rows, columns), "u1")
    file = slice_file(
        masks[0], "u8", "1.2.826.0.1.3680043.8.498.22", 1, ORIGIN, AXIAL,
        SOPClassUID="1.2.840.10008.5.1.4.1.1.66.4", Modality="SEG", BitsAllocated=1, BitsStored=1,
        HighBit=0, NumberOfFrames=frames, SegmentationType="BINARY", SpecificCharacterSet="ISO_IR 192",
        RescaleSlope=None, RescaleIntercept=None, RescaleType=None, ImagePositionPatient=None,
        ImageOrientationPatient=None,
    )  # fmt: skip
    file.PixelData = pack_bits(masks)
    file.SegmentSequence = Sequence()
    for number, name in ((1, "läver"), (2, "脾臓")):
        segment = Dataset()
        segment.SegmentNumber, segment.SegmentLabel = number, name
        file.SegmentSequence.append(segment)
    file.PerFrameFunctionalGroupsSequence = Sequence()
    for k in range(frames):
        group = nested("PlanePositionSequence", ImagePositionPatient=[0, 0, 3 * k])
        number = nested("SegmentIdentificationSequence", ReferencedSegmentNumber=1 + k % 2)
        group.update(number)
        file.PerFrameFunctionalGroupsSequence.append(group)
    shared = nested("PlaneOrientationSequence", ImageOrientationPatient=AXIAL)
    shared.update(nested("PixelMeasuresSequence", PixelSpacing=[1, 1], SpacingBetweenSlices=3))
    file.SharedFunctionalGroupsSequence = Sequence([shared])
    path = folder / "seg.dcm"
    save(file, path)
    witness = pydicom.dcmread(path).pixel_array
    labels = np.array([1, 2, 1, 2], "u1")[:, None, None] * witness
    yield Case("color/seg", [path], labels, labels={1: "läver", 2: "脾臓"})


def nested(keyword, **fields):
    inner, outer = Dataset(), Dataset()
    for name, value in fields.items():
        setattr(inner, name, value)
    setattr(outer, keyword, Sequence([inner]))
    return outer


def structure_sets(folder):
    """Random polygons, filled by the crossing number of every voxel's center."""
    rng = np.random.default_rng(23)
    slices, rows, columns = 4, 30, 40
    spacing = np.array([0.7, 1.3, 2.5])
    series = "1.2.826.0.1.3680043.8.498.23"
    home = folder / "structures"
    home.mkdir()
    for k in range(slices):
        picture = np.zeros((rows, columns), "u1")
        position = [ORIGIN[0], ORIGIN[1], ORIGIN[2] + spacing[2] * k]
        save(slice_file(picture, "u8", series, k + 1, position, AXIAL), home / f"{k}.dcm")
    expected = np.zeros((slices, rows, columns), "u1")
    contours = Sequence()
    for k in range(slices):
        for corners in (5, 40):
            polygon = rng.uniform([2, 2], [columns - 3, rows - 3], (corners, 2))
            expected[k] ^= crossings(polygon, rows, columns)
            contour = Dataset()
            contour.ContourGeometricType = "CLOSED_PLANAR"
            points = np.column_stack([polygon, np.full(corners, k)]) * spacing + ORIGIN
            contour.ContourData = [f"{n:.10g}" for n in points.ravel()]
            contours.append(contour)
    file = slice_file(
        expected[0], "u8", f"{series}.1", 1, ORIGIN, AXIAL,
        SOPClassUID="1.2.840.10008.5.1.4.1.1.481.3", Modality="RTSTRUCT", PixelData=None,
        SpecificCharacterSet="ISO_IR 192",
    )  # fmt: skip
    referenced = nested("RTReferencedSeriesSequence", SeriesInstanceUID=series)
    study = Dataset()
    study.RTReferencedStudySequence = Sequence([referenced])
    file.ReferencedFrameOfReferenceSequence = Sequence([study])
    roi, drawing = Dataset(), Dataset()
    roi.ROINumber, roi.ROIName = 1, "läver"
    drawing.ReferencedROINumber, drawing.ROIDisplayColor = 1, [255, 0, 0]
    drawing.ContourSequence = contours
    file.StructureSetROISequence = Sequence([roi])
    file.ROIContourSequence = Sequence([drawing])
    path = home / "rs.dcm"
    save(file, path)
    matrix = np.eye(4)
    matrix[:3, :3] = np.diag(spacing)
    matrix[:3, 3] = ORIGIN
    yield Case("color/structures", [path], expected, LPS_FROM_RAS @ matrix, labels={1: "läver"})


def crossings(polygon, rows, columns):
    """1 for centers from which a ray to the left crosses the polygon an odd number of times."""
    y, x = np.mgrid[:rows, :columns]
    inside = np.zeros((rows, columns), "u1")
    for (x0, y0), (x1, y1) in zip(polygon, np.roll(polygon, -1, axis=0)):
        spans = (y0 <= y) != (y1 <= y)
        at = x0 + (y - y0) / (y1 - y0) * (x1 - x0)
        inside ^= (spans & (at <= x)).astype("u1")
    return inside
