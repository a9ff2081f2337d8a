"""NumPy arrays, raw files and .dat headers: samples without a place in the world."""

import numpy as np

from case import TYPES, Case, samples

DAT_TYPES = {
    "u1": "UCHAR", "i1": "CHAR", "u2": "USHORT", "i2": "SHORT",
    "u4": "UINT", "i4": "INT", "f4": "FLOAT", "f8": "DOUBLE",
}  # fmt: skip
LONG_NAMES = {
    "u1": "uint8", "i1": "int8", "u2": "uint16", "i2": "int16",
    "u4": "uint32", "i4": "int32", "f4": "float32", "f8": "float64",
}  # fmt: skip


def placed(x=1.0, y=1.0, z=1.0):
    return np.diag([-x, -y, z, 1.0])


def cases(folder):
    for kind in TYPES:
        for endian in "<>":
            data = samples(np.dtype(kind).newbyteorder(endian))
            for fortran in (False, True):
                for version in ((1, 0), (2, 0), (3, 0)):
                    order = "f" if fortran else "c"
                    path = folder / f"{kind}-{endian == '<'}-{order}-{version[0]}.npy"
                    with path.open("wb") as file:
                        array = np.asfortranarray(data.T) if fortran else data
                        np.lib.format.write_array(file, array, version)
                    yield Case(f"npy/{path.name}", [path], data, placed())
            word = "le" if endian == "<" else "be"
            path = folder / f"scan-{kind}-{word}_3x4x5_{LONG_NAMES[kind]}{word}.raw"
            path.write_bytes(data.tobytes())
            yield Case(f"raw/{path.name}", [path], data, placed())
            path = folder / f"scan-{kind}-{word}"
            path.write_bytes(b"head" * 4 + data.tobytes())
            flags = ["--dims", "3,4,5", "--type", LONG_NAMES[kind], "--header-bytes", 16]
            flags += ["--endian", "little" if endian == "<" else "big", "--spacing", "0.5,0.7,2"]
            yield Case(f"raw/{path.name}", [path], data, placed(0.5, 0.7, 2), flags=flags)
            path = folder / f"scan-{kind}-{word}.dat"
            name = f"scan-{kind}-{word}_3x4x5_{LONG_NAMES[kind]}{word}.raw"
            path.write_text(
                f"ObjectFileName: {name}\nTaggedFileName: ---\nResolution: 3 4 5\n"
                f"SliceThickness: 0.5 0.7 2\nFormat: {DAT_TYPES[kind]}\nObjectModel: I\n"
                f"GridType: EQUIDISTANT\nEndianess: {'LITTLE' if endian == '<' else 'BIG'}\n"
            )
            yield Case(f"dat/{path.name}", [path], data, placed(0.5, 0.7, 2))
    movie = samples("u2", (4, 5, 4, 3))
    path = folder / "movie.npy"
    np.save(path, movie)
    for k in range(4):
        yield Case(f"npy/time {k}", [path], movie[k], flags=["--time", k])
    data = samples("u1")
    path = folder / "engine_3x4x5_uint8.raw"
    path.write_bytes(data.tobytes())
    yield Case("raw/by its name", [path], data, placed())
    for name, array, why in (
        ("complex", np.zeros((2, 2, 2), "c8"), "complex"),
        ("objects", np.array([[[None]]]), "descr"),
    ):
        path = folder / f"{name}.npy"
        np.save(path, array)
        yield Case(f"npy/{name}", [path], refused=why)
