"""TIFF stacks, and sequences of TIFF and PNG, written by tifffile and imageio."""

import imageio.v3 as imageio
import numpy as np
import tifffile

from array_cases import placed
from case import TYPES, Case, samples


def cases(folder):
    for kind in TYPES:
        data = samples(kind, (5, 32, 48))
        for endian in "<>":
            for big in (False, True):
                name = f"{kind}-{'le' if endian == '<' else 'be'}{'-big' if big else ''}.tif"
                path = folder / name
                tifffile.imwrite(
                    path, data, byteorder=endian, bigtiff=big, photometric="minisblack", metadata=None
                )
                yield Case(f"tiff/{name}", [path], tifffile.imread(path), placed())
        for compression in ("zlib", "lzw", "packbits", "zstd"):
            for predictor in (False, True):
                if predictor and compression == "packbits":
                    continue
                for tile in (None, (16, 16)):
                    name = f"{kind}-{compression}-{predictor}-{tile is not None}.tif"
                    path = folder / name
                    tifffile.imwrite(
                        path,
                        data,
                        compression=compression,
                        predictor=predictor,
                        tile=tile,
                        photometric="minisblack",
                        metadata=None,
                    )
                    yield Case(f"tiff/{name}", [path], tifffile.imread(path), placed())
    data = samples("u2", (5, 32, 48))
    path = folder / "imagej.tif"
    tifffile.imwrite(
        path,
        data,
        imagej=True,
        resolution=(1 / 0.5, 1 / 0.25),
        metadata={"axes": "ZYX", "spacing": 2.0, "unit": "mm"},
    )
    yield Case("tiff/imagej", [path], data, placed(0.5, 0.25, 2.0))
    path = folder / "imagej-micron.tif"
    tifffile.imwrite(
        path,
        data,
        imagej=True,
        resolution=(1 / 0.5, 1 / 0.5),
        metadata={"axes": "ZYX", "spacing": 2.0, "unit": "um"},
    )
    yield Case("tiff/imagej in µm", [path], data, placed(0.0005, 0.0005, 0.002))
    path = folder / "scan.ome.tif"
    tifffile.imwrite(
        path,
        data,
        ome=True,
        photometric="minisblack",
        metadata={
            "axes": "ZYX",
            "PhysicalSizeX": 0.5,
            "PhysicalSizeXUnit": "mm",
            "PhysicalSizeY": 0.25,
            "PhysicalSizeYUnit": "mm",
            "PhysicalSizeZ": 2.0,
            "PhysicalSizeZUnit": "mm",
        },
    )
    yield Case("tiff/ome", [path], data, placed(0.5, 0.25, 2.0))

    for kind in ("u1", "u2"):
        data = samples(kind, (12, 20, 30))
        for ending in ("tif", "png"):
            sequence = folder / f"sequence-{kind}-{ending}"
            sequence.mkdir(exist_ok=True)
            for k, picture in enumerate(data):
                # Without leading zeros: 10 must come after 9.
                imageio.imwrite(sequence / f"slice{k + 1}.{ending}", picture)
            yield Case(
                f"slices/{sequence.name}",
                [sequence],
                data,
                placed(0.5, 0.5, 2),
                flags=["--spacing", "0.5,0.5,2"],
            )
    uneven = folder / "uneven"
    uneven.mkdir(exist_ok=True)
    imageio.imwrite(uneven / "slice1.png", np.zeros((20, 30), "u1"))
    imageio.imwrite(uneven / "slice2.png", np.zeros((20, 31), "u1"))
    yield Case("slices/of two sizes", [uneven], refused="slice2.png")
    colour = folder / "colour.tif"
    pixels = samples("u1", (5, 20, 30, 3))
    tifffile.imwrite(colour, pixels, photometric="rgb")
    luminance = np.rint(pixels @ [0.2126, 0.7152, 0.0722]).astype("u1")
    flags = ["--component", "luminance"]
    yield Case("tiff/colour", [colour], luminance, flags=flags, note="luminance")
