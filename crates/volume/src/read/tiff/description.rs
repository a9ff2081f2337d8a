//! What ImageJ and OME write into a stack's ImageDescription; [`shaped`] has what tifffile does.
//!
//! ```text
//! ImageJ=1.53t        <OME …><Image …><Pixels DimensionOrder="XYZCT" SizeZ="5" SizeC="1" SizeT="1"
//! images=5                 PhysicalSizeX="0.5" PhysicalSizeXUnit="µm" …>
//! channels=1
//! slices=5
//! frames=1
//! unit=micron
//! spacing=2.0
//! ```
//!
//! ImageJ keeps the distance of pixels as resolution: pixels per `unit`.

use super::lengths::mm_per;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Writer {
    ImageJ,
    Ome,
    /// The Python library.
    Tifffile,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Description {
    pub(super) writer: Writer,
    /// Pictures in the file, if said.
    pub(super) images: Option<usize>,
    pub(super) channels: usize,
    pub(super) slices: usize,
    pub(super) times: usize,
    /// Whether the time points of one slice follow each other.
    pub(super) time_is_faster: bool,
    /// Whether the file does not say which axis is time.
    pub(super) is_guessed: bool,
    /// Along x, y, z, in mm per `unit` where one is known.
    spacing: [Option<f64>; 3],
    has_unit: bool,
}

impl Description {
    /// One slice of which nothing is said.
    pub(super) fn of_writer(writer: Writer) -> Description {
        Description {
            writer,
            images: None,
            channels: 1,
            slices: 1,
            times: 1,
            time_is_faster: false,
            is_guessed: false,
            spacing: [None; 3],
            has_unit: false,
        }
    }

    /// Nothing if neither of the two wrote it.
    pub(super) fn parse(text: &str, resolution: Option<[f64; 2]>) -> Option<Description> {
        if text.starts_with("ImageJ=") {
            Some(imagej(text, resolution))
        } else {
            ome(text)
        }
    }

    /// Distance between voxel centers and whether it has a length unit, if anything is said of it.
    pub(super) fn spacing_mm(&self, notes: &mut Vec<String>) -> Option<([f64; 3], bool)> {
        let [x, y, z] = self.spacing;
        let known = x.or(y).or(z)?;
        for (axis, missing) in ["x", "y", "z"]
            .iter()
            .zip(self.spacing.map(|s| s.is_none()))
        {
            if missing {
                notes.push(format!(
                    "no spacing along {axis} in the description; {known} is taken"
                ));
            }
        }
        Some((self.spacing.map(|s| s.unwrap_or(known)), self.has_unit))
    }
}

fn imagej(text: &str, resolution: Option<[f64; 2]>) -> Description {
    let value = |key: &str| {
        text.lines()
            .find_map(|line| line.trim().strip_prefix(key)?.strip_prefix('='))
    };
    let count = |key: &str| value(key).and_then(|v| v.trim().parse().ok());
    let unit_mm = value("unit").and_then(|unit| mm_per(unit.trim()));
    let depth = value("spacing")
        .and_then(|v| v.trim().parse().ok())
        .and_then(positive);
    let images = count("images");
    let (slices, times) = (count("slices"), count("frames"));
    let unit = unit_mm.unwrap_or(1.0);
    // ImageJ leaves out what is 1. If it says nothing at all, nothing is known.
    let says_something = unit_mm.is_some() || depth.is_some();
    let [x, y] = match resolution {
        Some(per_unit) => per_unit.map(|pixels| positive(unit / pixels)),
        None => [says_something.then_some(unit); 2],
    };
    Description {
        writer: Writer::ImageJ,
        images,
        channels: count("channels").unwrap_or(1),
        slices: slices.unwrap_or_else(|| match times {
            Some(_) => 1,
            None => images.unwrap_or(1),
        }),
        times: times.unwrap_or(1),
        time_is_faster: false,
        is_guessed: false,
        spacing: if says_something {
            [x, y, positive(depth.unwrap_or(1.0) * unit)]
        } else {
            [None; 3]
        },
        has_unit: unit_mm.is_some(),
    }
}

fn ome(text: &str) -> Option<Description> {
    if !text.contains("<OME") && !text.contains(":OME") {
        return None;
    }
    // The element may have a namespace prefix.
    let start = text.find("<Pixels ").or_else(|| text.find(":Pixels "))?;
    let element = &text[start..];
    let element = &element[..element.find('>')?];
    let attribute = |name: &str| {
        let start = element.find(&format!(" {name}=\""))? + name.len() + 3;
        let value = &element[start..];
        Some(&value[..value.find('"')?])
    };
    let count = |name| attribute(name).and_then(|v| v.parse().ok());
    let mut has_unit = true;
    let mut length = |axis| {
        let number: f64 = attribute(&format!("PhysicalSize{axis}"))?.parse().ok()?;
        let unit_mm = match attribute(&format!("PhysicalSize{axis}Unit")) {
            Some(unit) => mm_per(unit),
            None => Some(1e-3),
        };
        has_unit &= unit_mm.is_some();
        positive(number * unit_mm.unwrap_or(1.0))
    };
    let spacing = [length("X"), length("Y"), length("Z")];
    let order = attribute("DimensionOrder").unwrap_or("XYZCT");
    Some(Description {
        writer: Writer::Ome,
        images: None,
        channels: count("SizeC").unwrap_or(1),
        slices: count("SizeZ").unwrap_or(1),
        times: count("SizeT").unwrap_or(1),
        time_is_faster: order.find('T') < order.find('Z'),
        is_guessed: false,
        spacing,
        has_unit,
    })
}

fn positive(value: f64) -> Option<f64> {
    Some(value).filter(|v| v.is_finite() && *v > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn imagej_says_what_is_not_one() {
        let text = "ImageJ=1.53t\nimages=6\nslices=3\nframes=2\nhyperstack=true\nunit=\\u00B5m\nspacing=2.5\nloop=false\n";
        let found = Description::parse(text, Some([2.0, 4.0])).unwrap();
        assert_eq!(
            (found.images, found.slices, found.times, found.channels),
            (Some(6), 3, 2, 1)
        );
        let (spacing, has_unit) = found.spacing_mm(&mut Vec::new()).unwrap();
        assert_eq!(spacing, [0.0005, 0.00025, 0.0025]);
        assert!(has_unit);

        let plain = Description::parse("ImageJ=1.53t\nimages=6\n", Some([1.0, 1.0])).unwrap();
        assert_eq!((plain.slices, plain.times), (6, 1));
        assert_eq!(plain.spacing_mm(&mut Vec::new()), None);

        let broken = "ImageJ=\nunit=pixel\nspacing=NaN\nslices=x\n";
        let broken = Description::parse(broken, None).unwrap();
        assert_eq!(broken.spacing_mm(&mut Vec::new()), None);
    }

    #[test]
    fn ome_has_a_unit_of_its_own_for_each_axis() {
        let text = "<?xml version=\"1.0\"?><OME xmlns=\"x\"><Image ID=\"Image:0\"><Pixels ID=\"Pixels:0\" DimensionOrder=\"XYCTZ\" SizeX=\"4\" SizeZ=\"3\" SizeC=\"1\" SizeT=\"2\" PhysicalSizeX=\"0.5\" PhysicalSizeY=\"500\" PhysicalSizeYUnit=\"nm\" PhysicalSizeZ=\"0.002\" PhysicalSizeZUnit=\"mm\"></Pixels></Image></OME>";
        let found = Description::parse(text, None).unwrap();
        let (spacing, has_unit) = found.spacing_mm(&mut Vec::new()).unwrap();
        for (found, expected) in spacing.iter().zip([0.0005, 0.0005, 0.002]) {
            assert!((found - expected).abs() < 1e-15, "{spacing:?}");
        }
        assert!(has_unit && found.time_is_faster);
        assert_eq!((found.slices, found.times), (3, 2));

        let mut notes = Vec::new();
        let flat = text.replace("PhysicalSizeZ", "Other");
        let flat = Description::parse(&flat, None).unwrap();
        assert_eq!(flat.spacing_mm(&mut notes).unwrap().0[2], 0.0005);
        assert!(notes[0].contains("along z"), "{notes:?}");
        assert_eq!(Description::parse("made by hand", None), None);
    }
}
