"""The scans beside the checkout."""

import json

import nibabel as nib
import numpy as np
import pydicom

from case import LPS_FROM_RAS, Case


def cases(data):
    for path in sorted(data.glob("*.nii.gz")):
        image = nib.load(path)
        stored = np.asanyarray(image.dataobj.get_unscaled())
        slope, intercept = image.dataobj.slope, image.dataobj.inter
        yield Case(f"shared/{path.name}", [path], stored.T, image.affine, slope, intercept)
    place = data / "head-mr-dicom"
    if place.is_dir():
        files = [pydicom.dcmread(path) for path in sorted(place.iterdir())]
        x, y = np.array(files[0].ImageOrientationPatient, float).reshape(2, 3)
        normal = np.cross(x, y)
        files.sort(key=lambda file: normal @ np.array(file.ImagePositionPatient, float))
        first, last = (np.array(files[i].ImagePositionPatient, float) for i in (0, -1))
        down, across = map(float, files[0].PixelSpacing)
        matrix = np.eye(4)
        matrix[:3, :3] = np.array([x * across, y * down, (last - first) / (len(files) - 1)]).T
        matrix[:3, 3] = first
        slope = float(getattr(files[0], "RescaleSlope", 1))
        intercept = float(getattr(files[0], "RescaleIntercept", 0))
        stored = np.stack([file.pixel_array for file in files])
        yield Case("shared/head-mr-dicom", [place], stored, LPS_FROM_RAS @ matrix, slope, intercept)
