"""Times VTK's fixed-point ray caster on one case of cases.json; prints one line of JSON.

    python vtk_peer.py --data FOLDER --case engine --mode shaded [--frames 16] [--threads 2] [--step 1.0] [--raw FILE]

`cargo xtask bench-peers` runs it in turns with crates/cpu/examples/time_frames.rs, which has the same modes:

unshaded, shaded  emission and absorption
mip               the largest value of a ray, coloured by the transfer function
mip-values        the same, coloured black to white over 0 to 255: a picture of values
first-hit         the mapper has no isosurfaces: the stand-in is a transfer function that is opaque from the
                  threshold on, shaded. It casts the same rays to the same places, but looks no further for the
                  place between two samples where the threshold is reached.

Seconds of a frame are those of Render(): the picture lies in the frame buffer. `first_s` begins with the decoded
voxels in memory and ends with the first picture; the window has been opened before. `window_s` is a frame of the
empty window, which is in every other one. --raw writes the last frame, RGB,
8 bits, row by row from the top.
"""

import argparse
import json
import os
import time

import nibabel
import numpy
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

FOLDER = os.path.dirname(os.path.abspath(__file__))
MODES = ["unshaded", "shaded", "mip", "mip-values", "first-hit"]


def parse_arguments(spec):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", required=True, help="folder of the scans")
    parser.add_argument("--case", required=True, choices=sorted(spec["cases"]))
    parser.add_argument("--mode", required=True, choices=MODES)
    parser.add_argument("--frames", type=int, default=16, help="pictures of one turn")
    parser.add_argument("--threads", type=int, default=0, help="0: all cores")
    parser.add_argument("--step", type=float, default=spec["step_in_voxels"], help="in voxel edges")
    parser.add_argument("--size", type=int, default=spec["size"][0], help="edge of the picture in pixels")
    parser.add_argument("--raw", help="file for the last frame")
    return parser.parse_args()


def make_image(voxels, spacing):
    image = vtk.vtkImageData()
    image.SetDimensions(voxels.shape)
    image.SetSpacing(spacing)
    image.GetPointData().SetScalars(numpy_to_vtk(voxels.ravel(order="F"), deep=0))
    return image


def make_mapper(arguments, image):
    mapper = vtk.vtkFixedPointVolumeRayCastMapper()
    # Without these the mapper trades quality for time as it pleases.
    mapper.SetAutoAdjustSampleDistances(0)
    mapper.SetLockSampleDistanceToInputSpacing(0)
    mapper.SetImageSampleDistance(1.0)
    mapper.SetSampleDistance(arguments.step)
    mapper.SetInteractiveSampleDistance(arguments.step)
    if arguments.threads:
        mapper.SetNumberOfThreads(arguments.threads)
    if arguments.mode.startswith("mip"):
        mapper.SetBlendModeToMaximumIntensity()
    mapper.SetInputData(image)
    return mapper


def make_property(arguments, spec, case):
    colors, opacities = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
    if arguments.mode == "mip-values":
        colors.AddRGBPoint(0, 0, 0, 0)
        colors.AddRGBPoint(255, 1, 1, 1)
        opacities.AddPoint(0, 1)
        opacities.AddPoint(255, 1)
    else:
        for value, opacity, color in case["points"]:
            colors.AddRGBPoint(value, *color)
            opacities.AddPoint(value, opacity)
    if arguments.mode == "first-hit":
        threshold = case["first_hit"]
        opacities.RemoveAllPoints()
        # The mapper looks whole numbers up: no value lies between the two.
        for value, opacity in [(0, 0), (threshold - 1e-3, 0), (threshold, 1), (255, 1)]:
            opacities.AddPoint(value, opacity)
    properties = vtk.vtkVolumeProperty()
    properties.SetColor(colors)
    properties.SetScalarOpacity(opacities)
    properties.SetInterpolationTypeToLinear()
    # Opacities hold for one voxel edge; the mapper converts them to its step.
    properties.SetScalarOpacityUnitDistance(1.0)
    if arguments.mode in ("shaded", "first-hit"):
        phong = spec["phong"]
        properties.ShadeOn()
        properties.SetAmbient(phong["ambient"])
        properties.SetDiffuse(phong["diffuse"])
        properties.SetSpecular(phong["specular"])
        properties.SetSpecularPower(phong["power"])
    return properties


def write_raw(window, path):
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.Update()
    image = grab.GetOutput()
    width, height, _ = image.GetDimensions()
    pixels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)
    numpy.ascontiguousarray(pixels[::-1, :, :3]).astype(numpy.uint8).tofile(path)


def main():
    with open(os.path.join(FOLDER, "cases.json"), encoding="utf-8") as file:
        spec = json.load(file)
    arguments = parse_arguments(spec)
    case = spec["cases"][arguments.case]
    vtk.vtkObject.GlobalWarningDisplayOff()
    if arguments.threads:
        vtk.vtkSMPTools.Initialize(arguments.threads)
        vtk.vtkMultiThreader.SetGlobalMaximumNumberOfThreads(arguments.threads)

    scan = nibabel.load(os.path.join(arguments.data, case["file"]))
    voxels = numpy.asfortranarray(scan.dataobj)
    spacing = [float(length) for length in scan.header.get_zooms()[:3]]

    renderer = vtk.vtkRenderer()
    renderer.SetBackground(0, 0, 0)
    # The light that VTK makes itself has no ambient share, and the mapper takes that of lights.
    light = vtk.vtkLight()
    light.SetLightTypeToHeadlight()
    light.SetAmbientColor(1, 1, 1)
    renderer.AddLight(light)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(arguments.size, arguments.size)
    window.AddRenderer(renderer)
    window.Render()
    empty = []
    for _ in range(5):
        start = time.perf_counter()
        window.Render()
        empty.append(time.perf_counter() - start)

    start = time.perf_counter()
    volume = vtk.vtkVolume()
    volume.SetMapper(make_mapper(arguments, make_image(voxels, spacing)))
    volume.SetProperty(make_property(arguments, spec, case))
    renderer.AddVolume(volume)
    renderer.ResetCamera()
    camera = renderer.GetActiveCamera()
    camera.SetViewAngle(spec["view_angle_deg"])
    camera.Elevation(spec["elevation_deg"])
    camera.Azimuth(spec["azimuth_deg"])
    camera.Zoom(spec["zoom"])
    renderer.ResetCameraClippingRange()
    window.Render()
    first = time.perf_counter() - start

    seconds = []
    for _ in range(arguments.frames):
        camera.Azimuth(360.0 / arguments.frames)
        renderer.ResetCameraClippingRange()
        start = time.perf_counter()
        window.Render()
        seconds.append(time.perf_counter() - start)
    if arguments.raw:
        write_raw(window, arguments.raw)
    print(
        json.dumps(
            {
                "renderer": "VTK " + vtk.vtkVersion.GetVTKVersion(),
                "case": arguments.case,
                "mode": arguments.mode,
                "threads": volume.GetMapper().GetNumberOfThreads(),
                "step": arguments.step,
                "window_s": sorted(empty)[len(empty) // 2],
                "first_s": first,
                "seconds": seconds,
            }
        )
    )


main()
