"""MetaImage, written and read by SimpleITK."""

import numpy as np
import SimpleITK as sitk

from case import TYPES, Case, axis_orders, rotation, samples
from nrrd_cases import sitk_affine


def image_of(data, directions, spacing=(0.7, 1.3, 2.1), origin=(-31.5, 12.25, 90.0)):
    image = sitk.GetImageFromArray(data)
    image.SetSpacing(spacing)
    image.SetOrigin(origin)
    image.SetDirection(np.asarray(directions).ravel())
    return image


def cases(folder):
    for kind in TYPES:
        for ending in (".mha", ".mhd"):
            for packed in (False, True):
                path = folder / f"{kind}-{'zlib' if packed else 'raw'}{ending}"
                sitk.WriteImage(image_of(samples(kind), rotation(5)), str(path), packed)
                image = sitk.ReadImage(str(path))
                yield Case(
                    f"metaimage/{path.name}",
                    [path],
                    sitk.GetArrayFromImage(image),
                    sitk_affine(image),
                )
    data = samples("i2")
    for number, directions in enumerate(axis_orders()):
        if np.linalg.det(directions) < 0:
            continue  # ITK itself wants right-handed axes
        path = folder / f"order-{number}.mha"
        sitk.WriteImage(image_of(data, directions), str(path))
        yield Case(
            f"metaimage/axis order {number}", [path], data, sitk_affine(sitk.ReadImage(str(path)))
        )

    # Big endian and text: SimpleITK reads them but does not write them.
    for name, order, text in (("big", ">i2", False), ("text", "<i2", True), ("big text", ">i2", True)):
        path = folder / f"{name}.mha"
        head = (
            "ObjectType = Image\nNDims = 3\n"
            f"BinaryData = {not text}\nBinaryDataByteOrderMSB = {order[0] == '>'}\n"
            "CompressedData = False\nTransformMatrix = 0 1 0 1 0 0 0 0 -1\nOffset = 1 2 3\n"
            "CenterOfRotation = 0 0 0\nElementSpacing = 0.5 1.5 2.5\nDimSize = 3 4 5\n"
            "ElementType = MET_SHORT\nElementDataFile = LOCAL\n"
        )
        body = (
            (" ".join(map(str, data.ravel())) + "\n").encode() if text else data.astype(order).tobytes()
        )
        path.write_bytes(head.encode() + body)
        image = sitk.ReadImage(str(path))
        # ITK swaps the bytes even of numbers that were text; they have no order.
        stored = data if text else sitk.GetArrayFromImage(image)
        yield Case(f"metaimage/{name}", [path], stored, sitk_affine(image))

    # Slices in files of their own, and a header before the samples.
    for k, slice_ in enumerate(data):
        (folder / f"slice{k + 1}.raw").write_bytes(slice_.tobytes())
    (folder / "headed.raw").write_bytes(b"h" * 100 + data.tobytes())
    start = (
        "ObjectType = Image\nNDims = 3\nDimSize = 3 4 5\nElementType = MET_SHORT\n"
        "ElementSpacing = 0.5 1.5 2.5\n"
    )
    for name, end in (
        ("list", "ElementDataFile = LIST\n" + "".join(f"slice{k}.raw\n" for k in range(1, 6))),
        ("pattern", "ElementDataFile = slice%d.raw 1 5 1\n"),
        ("header size", "HeaderSize = 100\nElementDataFile = headed.raw\n"),
        ("header size -1", "HeaderSize = -1\nElementDataFile = headed.raw\n"),
    ):
        path = folder / f"{name}.mhd"
        path.write_text(start + end)
        image = sitk.ReadImage(str(path))
        # ITK swaps the bytes even of numbers that were text; they have no order.
        stored = data if text else sitk.GetArrayFromImage(image)
        yield Case(f"metaimage/{name}", [path], stored, sitk_affine(image))

    movie = samples("u2", (4, 5, 4, 3))
    path = folder / "time.mha"
    image = sitk.GetImageFromArray(movie, isVector=False)
    image.SetSpacing([0.7, 1.3, 2.1, 1])
    sitk.WriteImage(image, str(path))
    for k in range(4):
        yield Case(f"metaimage/time {k}", [path], movie[k], flags=["--time", k])
