//! Tests of the crate as its users see it.

mod camera;
mod emptiness;
mod parse;
mod places;
mod problems;
mod random;
mod settled;
mod transfer;

use glam::{DAffine3, DMat3, DVec3};
use strahl_volume::{
    Grid, Metadata, Modality, Rescale, SampleType, Statistics, Volume, VolumeHeader,
};

/// The header of a volume of `dims` voxels 1 mm apart, axes R, A, S, with its first voxel at `first`.
fn header_at(dims: [usize; 3], first: DVec3) -> VolumeHeader {
    let grid = Grid::new(
        dims,
        DAffine3::from_mat3_translation(DMat3::IDENTITY, first),
    )
    .unwrap();
    VolumeHeader {
        grid,
        sample_type: SampleType::U8,
        rescale: Rescale::IDENTITY,
        statistics: Statistics {
            range: [0.0, 255.0],
            histogram: (0..256).map(|bin| 1000 / (1 + bin)).collect(),
            not_finite: 0,
        },
        metadata: Metadata::default(),
    }
}

/// The grid of the engine scan, as its file says.
fn engine() -> VolumeHeader {
    header_at([256, 256, 128], DVec3::new(-127.0, -127.0, -64.0))
}

/// A head in Hounsfield units, 0.5×0.5×1 mm, placed off the origin as scanners do.
fn ct_head() -> VolumeHeader {
    let grid = Grid::new(
        [400, 400, 200],
        DAffine3::from_mat3_translation(
            DMat3::from_diagonal(DVec3::new(-0.5, -0.5, 1.0)),
            DVec3::new(101.0, 120.0, -840.0),
        ),
    )
    .unwrap();
    VolumeHeader {
        grid,
        sample_type: SampleType::I16,
        rescale: Rescale {
            slope: 1.0,
            intercept: -1024.0,
        },
        statistics: Statistics {
            range: [-1024.0, 3071.0],
            histogram: (0..1024u64)
                .map(|bin| match bin {
                    0..40 => 10_000,
                    240..300 => 5_000,
                    _ => 10,
                })
                .collect(),
            not_finite: 0,
        },
        metadata: Metadata {
            modality: Some(Modality::Ct),
            has_length_unit: true,
            ..Metadata::default()
        },
    }
}

/// The header of a small volume of `samples`.
fn header_of(samples: strahl_volume::Samples, rescale: Rescale) -> VolumeHeader {
    let grid = Grid::centered([samples.len(), 1, 1], DVec3::ONE).unwrap();
    Volume::new(grid, samples, rescale, Metadata::default())
        .unwrap()
        .header()
}
