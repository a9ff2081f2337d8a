//! TIFF stacks: one page per slice, classic TIFF and BigTIFF.
//!
//! | offset | bytes | classic TIFF                 | offset | bytes | BigTIFF              |
//! |--------|-------|------------------------------|--------|-------|----------------------|
//! | 0      | 2     | `II` little, `MM` big endian | 0      | 2     | the same             |
//! | 2      | 2     | 42                           | 2      | 2     | 43                   |
//! | 4      | 4     | position of the first page   | 4      | 2, 2  | 8, 0                 |
//! |        |       |                              | 8      | 8     | position of the page |
//!
//! A page is a directory ([`directory`]): tags that say its size, its type and where its strips or
//! tiles lie ([`decode`]). What the slices mean, ImageJ and OME write as text into the first page
//! ([`description`]), tifffile its axes ([`shaped`]), MetaMorph how many planes follow a page ([`metamorph`]). ImageJ writes stacks beyond 4 GiB with a directory for the first page only;
//! the samples of the others follow it.

mod decode;
mod description;
mod directory;
mod lengths;
mod metamorph;
mod palette;
mod shaped;
mod source;

use super::block::{self, Block, Endian};
use super::components::{self, Choice, Meaning};
use super::stored::Stored;
use super::{Bytes, Input, LoadedVolume, ReadOptions, unoriented};
use crate::error::{Error, ErrorKind};
use crate::{Components, Grid, Metadata, Modality, Rescale, SampleType, Samples, Volume, memory};
use description::{Description, Writer};
use directory::{Directories, Page, Photometric};
use palette::Palette;

pub(crate) fn read(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let file = Directories::read(input.bytes)?;
    let mut notes = Vec::new();
    let first = file.first()?;
    same_pages(&file.pages)?;
    let described = described(&file);
    let colors = colors(&file, first, described.as_ref(), options, &mut notes);
    if file.reduced > 0 {
        notes.push(format!(
            "left out {} pages that are reduced copies of others",
            file.reduced
        ));
    }

    let images = Images::find(&file, described.as_ref(), input.bytes, &mut notes)?;
    let order = Order::of(
        described.as_ref(),
        first.numbers,
        images.count(),
        &mut notes,
    )?;
    let choice = colors.choice(options, &mut notes)?;
    if options.time_index >= order.times {
        return Err(Error::field(
            "time point",
            options.time_index,
            format!("0 to {}", order.times - 1),
        ));
    }

    let dims = [first.pixels(), first.height, order.slices * first.depth];
    let of_file = spacing_mm(&file, described.as_ref(), &mut notes);
    let (spacing_mm, has_length_unit) = unoriented::spacing_mm(options, of_file);
    let grid = unoriented::grid(dims, spacing_mm)?;
    let mut samples = Samples::new(first.sample_type);
    let count = components::total(grid.voxel_count(), first.numbers)?;
    input
        .bytes
        .keep(block::bytes_of(count, first.sample_type))?;
    reserve(&mut samples, &grid, &file)?;
    for slice in 0..order.slices {
        let image = order.image(slice, options.time_index);
        images.append(image, input.bytes, file.endian, &mut samples)?;
    }

    let samples = first
        .stored
        .kept_of_bits(samples, input.bytes, &mut notes)?;
    let samples = colors.reduced(samples, choice)?;

    let mut entries = Vec::new();
    if described.is_none() && !file.description.is_empty() {
        entries.push(("ImageDescription".into(), file.description.clone()));
    }
    let volume = Volume::new(
        grid,
        samples,
        Rescale::IDENTITY,
        Metadata {
            name: input.name.to_owned(),
            format: if file.big { "BigTIFF" } else { "TIFF" }.into(),
            modality: (file.metamorph.is_some()
                || described.is_some_and(|d| d.writer == Writer::Ome))
            .then_some(Modality::Microscopy),
            has_length_unit,
            time_points: order.times,
            time_index: options.time_index,
            components: colors.components(),
            entries,
            ..Metadata::default()
        },
    )?;
    Ok(LoadedVolume {
        volume,
        labels: None,
        notes,
    })
}

/// One slice of a sequence.
pub(crate) struct Slice {
    pub(crate) dims: [usize; 2],
    pub(crate) samples: Samples,
    pub(crate) components: Components,
    /// Distance between voxel centers and whether it has a length unit, if the file says.
    pub(crate) spacing_mm: Option<([f64; 3], bool)>,
}

/// A TIFF with exactly one page.
pub(crate) fn read_slice(
    bytes: &dyn Bytes,
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<Slice, Error> {
    let file = Directories::read(bytes)?;
    let page = file.first()?;
    let planes = file.metamorph.as_ref().map_or(1, |found| found.planes);
    let slices = (file.pages.len() * page.depth).max(planes);
    if slices > 1 {
        return Err(ErrorKind::Slices(format!(
            "it has {slices} pages; a slice of a sequence has one. Name the file alone to read it as a stack"
        ))
        .into());
    }
    let described = described(&file);
    let colors = colors(&file, page, described.as_ref(), options, notes);
    let mut samples = Samples::new(page.sample_type);
    let count = page.width.saturating_mul(page.height);
    bytes.has_room(block::bytes_of(count, page.sample_type))?;
    decode::append(page, bytes, file.endian, &mut samples)?;
    let choice = colors.choice(options, notes)?;
    let samples = page.stored.kept_of_bits(samples, bytes, notes)?;
    Ok(Slice {
        dims: [page.pixels(), page.height],
        samples: colors.reduced(samples, choice)?,
        components: colors.components(),
        spacing_mm: spacing_mm(&file, described.as_ref(), notes),
    })
}

/// What the program that wrote the file says of its pages.
fn described(file: &Directories) -> Option<Description> {
    let known = Description::parse(&file.description, file.resolution);
    let numbers = file.pages.first().map_or(1, |page| page.numbers);
    known.or_else(|| shaped::parse(&file.description, numbers))
}

/// Distance between voxel centers and whether it has a length unit, if the file says anything of it.
fn spacing_mm(
    file: &Directories,
    described: Option<&Description>,
    notes: &mut Vec<String>,
) -> Option<([f64; 3], bool)> {
    match &file.metamorph {
        Some(found) => found.spacing_mm(notes),
        None => described?.spacing_mm(notes),
    }
}

fn same_pages(pages: &[Page]) -> Result<(), Error> {
    for page in pages {
        if page.shape() != pages[0].shape() {
            return Err(ErrorKind::Slices(format!(
                "page {} is {}, page {} is {}; the pages of a stack have one size and type",
                page.number,
                shape_text(page),
                pages[0].number,
                shape_text(&pages[0]),
            ))
            .into());
        }
    }
    Ok(())
}

fn shape_text(page: &Page) -> String {
    let depth = match page.depth {
        1 => String::new(),
        depth => format!(" x {depth}"),
    };
    let kind = match page.stored {
        Stored::Kept(kept) => kept.to_string(),
        other => format!("{other:?}").to_lowercase(),
    };
    let numbers = match page.numbers {
        1 => String::new(),
        n => format!(" of {n} numbers"),
    };
    format!("{} x {}{depth} {kind}{numbers}", page.pixels(), page.height)
}

/// What the numbers of a pixel stand for.
enum Colors<'a> {
    /// Themselves.
    Stored { numbers: usize, meaning: Meaning },
    /// An index of a palette.
    Indices(&'a Palette),
}

impl Colors<'_> {
    fn components(&self) -> Components {
        match self {
            Colors::Stored { numbers, meaning } => meaning.of(*numbers),
            Colors::Indices(palette) => palette.components(),
        }
    }

    fn choice(&self, options: &ReadOptions, notes: &mut Vec<String>) -> Result<Choice, Error> {
        let meaning = match self {
            Colors::Stored { meaning, .. } => *meaning,
            Colors::Indices(_) => Meaning::Color,
        };
        components::choice(self.components().count, meaning, options, notes)
    }

    fn reduced(&self, samples: Samples, choice: Choice) -> Result<Samples, Error> {
        match self {
            Colors::Stored { numbers, .. } => Ok(components::reduced(samples, *numbers, choice)),
            Colors::Indices(palette) => palette.applied(samples, choice),
        }
    }
}

/// Stored numbers are values, whatever shade they were shown in, unless a palette says what they stand for.
fn colors<'a>(
    file: &'a Directories,
    page: &Page,
    described: Option<&Description>,
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Colors<'a> {
    let are_labels = options.as_labels || options.label_table.is_some();
    // ImageJ writes the colors in which a gray stack was shown as a palette.
    let is_of_imagej = described.is_some_and(|d| d.writer == Writer::ImageJ);
    match &file.palette {
        Some(_) if is_of_imagej => {
            notes.push("ImageJ's colors are left out; the numbers are kept as they are".into());
        }
        Some(_) if are_labels => {
            notes.push("the colors of the palette are left out; its indices are the labels".into());
        }
        Some(palette) => return Colors::Indices(palette),
        None if page.photometric == Photometric::WhiteIsZero => {
            notes.push("the picture shows 0 as white; the numbers are kept as they are".into());
        }
        None => {}
    }
    Colors::Stored {
        numbers: page.numbers,
        meaning: page.meaning,
    }
}

/// Memory for all samples where the stored data makes them likely; [`decode`] adds what is missing
/// as data comes.
fn reserve(samples: &mut Samples, grid: &Grid, file: &Directories) -> Result<(), Error> {
    let likely = file.stored_bytes.saturating_mul(4) / samples.sample_type().size() as u64;
    let count = grid
        .voxel_count()
        .min(usize::try_from(likely).unwrap_or(usize::MAX));
    crate::with_samples!(samples, s => memory::reserve(s, count))
}

/// Where the images of a file lie.
enum Images<'a> {
    /// One page each.
    Pages(&'a [Page]),
    /// One after the other from `offset` on, `samples` in each.
    Contiguous {
        offset: u64,
        samples: usize,
        count: usize,
        sample_type: SampleType,
    },
}

impl<'a> Images<'a> {
    fn find(
        file: &'a Directories,
        described: Option<&Description>,
        bytes: &dyn Bytes,
        notes: &mut Vec<String>,
    ) -> Result<Images<'a>, Error> {
        let pages = Images::Pages(&file.pages);
        let (writer, promised) = match (&file.metamorph, described) {
            (Some(found), _) => ("MetaMorph", Some(found.planes)),
            (None, Some(described)) => match described.writer {
                Writer::ImageJ => ("ImageJ", described.images),
                Writer::Tifffile => ("tifffile", described.images),
                Writer::Ome => ("OME", None),
            },
            (None, None) => ("", None),
        };
        let Some(promised) = promised.filter(|n| *n != file.pages.len()) else {
            return Ok(pages);
        };
        if let ([page], Some(offset)) = (file.pages.as_slice(), file.pages[0].contiguous()) {
            let samples = page.width * page.height;
            let image_bytes = (samples * page.sample_type.size()) as u64;
            let found = bytes.len().saturating_sub(offset);
            let expected = image_bytes.saturating_mul(promised as u64);
            if found >= expected {
                return Ok(Images::Contiguous {
                    offset,
                    samples,
                    count: promised,
                    sample_type: page.sample_type,
                });
            }
            if found / image_bytes > 1 || file.metamorph.is_some() {
                return Err(ErrorKind::Truncated {
                    what: format!("the stack of {promised} images (according to {writer})"),
                    expected,
                    found,
                }
                .into());
            }
        }
        if file.metamorph.is_some() && file.pages.len() == 1 {
            return Err(ErrorKind::Unsupported {
                feature: format!("a packed MetaMorph stack of {promised} planes"),
                instead: "save it without compression".into(),
            }
            .into());
        }
        notes.push(format!(
            "{writer}'s description promises {promised} images, {} are there",
            file.pages.len()
        ));
        Ok(pages)
    }

    fn count(&self) -> usize {
        match self {
            Images::Pages(pages) => pages.len(),
            Images::Contiguous { count, .. } => *count,
        }
    }

    fn append(
        &self,
        image: usize,
        bytes: &dyn Bytes,
        endian: Endian,
        into: &mut Samples,
    ) -> Result<(), Error> {
        match *self {
            Images::Pages(pages) => decode::append(&pages[image], bytes, endian, into),
            Images::Contiguous {
                offset,
                samples,
                sample_type,
                ..
            } => {
                let before = (image * samples) as u64 * sample_type.size() as u64;
                let block = Block {
                    endian,
                    ..Block::raw(bytes, offset + before)
                };
                block.append(into, samples)
            }
        }
    }
}

/// How images make slices and time points.
struct Order {
    slices: usize,
    times: usize,
    time_is_faster: bool,
}

impl Order {
    /// Of pixels of several numbers these are the channels.
    fn of(
        described: Option<&Description>,
        numbers: usize,
        images: usize,
        notes: &mut Vec<String>,
    ) -> Result<Order, Error> {
        let all_slices = Order {
            slices: images,
            times: 1,
            time_is_faster: false,
        };
        let Some(described) = described else {
            return Ok(all_slices);
        };
        if described.channels > 1 && described.channels != numbers {
            return Err(Error::field(
                "number of channels",
                described.channels,
                "1; split the channels into files of their own (ImageJ: Image > Color > Split Channels)",
            ));
        }
        let (slices, times) = (described.slices, described.times);
        if slices.checked_mul(times) != Some(images) {
            if slices.max(times) > 1 {
                notes.push(format!(
                    "the description states {slices} slices at {times} times, but there are {images} pages: all are read as slices"
                ));
            }
            return Ok(all_slices);
        }
        if described.is_guessed {
            notes.push(format!(
                "the array has four axes without names; they are taken as {times} times of {slices} slices"
            ));
        }
        if slices == 1 && times > 1 {
            notes.push(format!(
                "the {times} time points of one slice are taken as slices"
            ));
            return Ok(all_slices);
        }
        Ok(Order {
            slices,
            times,
            time_is_faster: described.time_is_faster,
        })
    }

    fn image(&self, slice: usize, time: usize) -> usize {
        if self.time_is_faster {
            time + self.times * slice
        } else {
            slice + self.slices * time
        }
    }
}
