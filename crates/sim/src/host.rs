//! The bus to the host: what goes over it, and how long it takes (document §7.6.3).

use crate::spec::Spec;

/// Bytes of P, Δ and L of a tile: each of them in whole bytes per ray.
pub fn parameter_bytes(spec: &Spec) -> u64 {
    let w = &spec.widths;
    let rays = u64::from(spec.queue.bundle[0] * spec.queue.bundle[1]);
    let position = 3 * (1 + w.position_integer + w.position_fraction);
    let step = 3 * (1 + w.step_integer + w.step_fraction);
    let bytes = |bits: u32| u64::from(bits.div_ceil(8));
    rays * (bytes(position) + bytes(step) + bytes(w.length))
}

/// Bytes of the results of a tile.
pub fn result_bytes(spec: &Spec) -> u64 {
    let rays = u64::from(spec.queue.bundle[0] * spec.queue.bundle[1]);
    rays * u64::from(spec.widths.intensity.div_ceil(8))
}

/// Something that goes over the bus.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    /// What.
    pub what: &'static str,
    /// Width of a word in bits.
    pub bits: u32,
    /// Number of words.
    pub words: u64,
    /// Bytes.
    pub bytes: u64,
    /// How often.
    pub per: &'static str,
}

impl Transfer {
    /// Microseconds on a bus.
    pub fn microseconds(&self, spec: &Spec) -> f64 {
        self.bytes as f64 / spec.host.bus_mb_per_s
    }
}

/// The document's table of transfers, with the widths of the Spec and a volume of `voxels` voxels.
pub fn transfers(spec: &Spec, voxels: u64, distance_words: u64, map_words: u64) -> Vec<Transfer> {
    let w = &spec.widths;
    let rays = u64::from(spec.queue.bundle[0] * spec.queue.bundle[1]);
    let transfer = |what, bits: u32, words: u64, per| Transfer {
        what,
        bits,
        words,
        bytes: words * u64::from(bits.div_ceil(8)),
        per,
    };
    vec![
        transfer(
            "P",
            3 * (1 + w.position_integer + w.position_fraction),
            rays,
            "tile",
        ),
        transfer(
            "Δ",
            3 * (1 + w.step_integer + w.step_fraction),
            rays,
            "tile",
        ),
        transfer("result", w.intensity, rays, "tile"),
        transfer("L", w.length, rays, "tile"),
        transfer("reflectance map", 4 * w.intensity, map_words, "frame"),
        transfer("pre-classification table", w.data, 1 << 16, "frame"),
        transfer("post-classification table", w.data, 1 << w.data, "frame"),
        transfer("distances", w.distance, distance_words, "classification"),
        transfer("volume", 16, voxels, "volume"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 7.2 and 7.3 of the document.
    #[test]
    fn the_documents_transfer_times() {
        let spec = Spec::default();
        assert_eq!(parameter_bytes(&spec), 576 + 384 + 128);
        assert_eq!(result_bytes(&spec), 64);
        let per_tile = parameter_bytes(&spec) + result_bytes(&spec);
        for (tiles, milliseconds) in [(16384u64, 35.4), (4096, 8.85), (1024, 2.21)] {
            let time = (tiles * per_tile) as f64 / spec.host.bus_mb_per_s / 1000.0;
            assert!(
                (time - milliseconds).abs() < 0.05,
                "{tiles} tiles: {time} ms"
            );
        }
        let table = transfers(&spec, 1 << 30, 1 << 18, 6 << 6);
        let bytes = |what| table.iter().find(|t| t.what == what).unwrap().bytes;
        assert_eq!(bytes("P"), 576);
        assert_eq!(bytes("Δ"), 384);
        assert_eq!(bytes("reflectance map"), 1536);
        assert_eq!(bytes("volume"), 2 << 30);
    }
}
