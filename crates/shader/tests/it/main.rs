//! Tests of the crate from outside.

mod hostile;
mod library;
mod messages;

use strahl_shader::{RayLoop, Skeleton, Techniques, Texels, ray_loop};

/// The ray loop over one object.
fn one(texels: Texels) -> Skeleton {
    loop_over(&[texels], 1)
}

fn loop_over(volumes: &[Texels], objects: usize) -> Skeleton {
    let volumes_are_whole = matches!(volumes[0], Texels::Unsigned | Texels::Signed);
    let volumes = volumes.to_vec();
    ray_loop(&RayLoop {
        volumes,
        objects,
        is_before_geometry: objects > 1,
        techniques: Techniques::One,
        is_finite: volumes_are_whole,
        has_important_places: false,
    })
    .unwrap()
}
