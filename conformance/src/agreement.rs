//! How alike two pictures of the same scene are.

use strahl_scene::Image;

/// What is seen of the difference of two pictures, in channels from 0 to 1 as a screen shows them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Peak signal to noise ratio in dB over all channels; infinite if equal.
    pub psnr_db: f64,
    /// Share of the pixels with a channel that is off by more than [`FAR`].
    pub far: f64,
    /// How many of those are not at a silhouette: where the first picture changes by more than
    /// [`SILHOUETTE`] to a neighbor, a sample may fall on either side of an edge in single precision.
    pub far_outside_silhouettes: usize,
    /// The largest difference of a channel.
    pub most: f64,
}

/// 8 levels of 255.
pub const FAR: f64 = 8.0 / 255.0;

/// 24 levels of 255, three times what counts as far.
pub const SILHOUETTE: f64 = 24.0 / 255.0;

/// Compares `b` with `a`, of the same size: linear, premultiplied.
pub fn agreement(a: &Image, b: &Image) -> Agreement {
    // A square root stands for the curve of the screen.
    let seen = |pixel: &[f32; 4]| pixel.map(|v| f64::from(v.clamp(0.0, 1.0)).sqrt());
    let first: Vec<[f64; 4]> = a.pixels().iter().map(seen).collect();
    let (width, height) = (a.width() as usize, a.height() as usize);
    let apart = |p: &[f64; 4], q: &[f64; 4]| {
        let channels = p.iter().zip(q).map(|(p, q)| (p - q).abs());
        channels.fold(0.0, f64::max)
    };
    let is_silhouette = |i: usize| {
        let (x, y) = (i % width, i / width);
        (x.saturating_sub(1)..(x + 2).min(width)).any(|x| {
            (y.saturating_sub(1)..(y + 2).min(height))
                .any(|y| apart(&first[y * width + x], &first[i]) > SILHOUETTE)
        })
    };
    let (mut sum, mut far, mut outside, mut most) = (0.0, 0usize, 0usize, 0.0f64);
    for (i, (p, q)) in first.iter().zip(b.pixels()).enumerate() {
        let q = seen(q);
        sum += p.iter().zip(&q).map(|(p, q)| (p - q).powi(2)).sum::<f64>();
        let worst = apart(p, &q);
        if worst > FAR {
            far += 1;
            outside += usize::from(!is_silhouette(i));
        }
        most = most.max(worst);
    }
    let n = first.len() as f64;
    Agreement {
        psnr_db: -10.0 * (sum / (4.0 * n)).log10(),
        far: far as f64 / n,
        far_outside_silhouettes: outside,
        most,
    }
}
