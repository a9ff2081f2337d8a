//! Transfer functions: value → color and opacity.

use std::ops::Range;

/// A transfer function as every renderer uses it: evenly spaced entries, linear in between, the
/// first and last entry beyond the ends.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferTable {
    domain: [f32; 2],
    reference_mm: f32,
    entries: Vec<[f32; 4]>,
    /// Empty if the function is one of the value alone.
    rows: Vec<[f32; 4]>,
}

impl TransferTable {
    /// A table over the values `domain[0] < domain[1]`; `entries` (at least two) hold linear RGB, not
    /// multiplied by alpha, and the opacity of `reference_mm` millimeters of material.
    ///
    /// # Panics
    /// If there are fewer than two entries, the domain is empty, or the reference is not above 0.
    pub fn new(domain: [f32; 2], reference_mm: f32, entries: Vec<[f32; 4]>) -> TransferTable {
        assert!(entries.len() >= 2 && domain[0] < domain[1] && reference_mm > 0.0);
        TransferTable {
            domain,
            reference_mm,
            entries,
            rows: Vec::new(),
        }
    }

    /// A function of value and gradient magnitude: rows of `columns` entries each, from no gradient to the largest, whatever that is.
    /// As a function of the value alone it has the largest opacity of each column.
    ///
    /// # Panics
    /// As [`new`](Self::new); if there are fewer than two rows, or one is not whole.
    pub fn of_rows(
        domain: [f32; 2],
        reference_mm: f32,
        columns: usize,
        rows: Vec<[f32; 4]>,
    ) -> TransferTable {
        assert!(columns > 0 && rows.len() >= 2 * columns && rows.len().is_multiple_of(columns));
        let most = |column: usize| {
            let of_column = rows.iter().skip(column).step_by(columns);
            of_column.fold(
                [0.0f32; 4],
                |most, e| if e[3] > most[3] { *e } else { most },
            )
        };
        let entries = (0..columns).map(most).collect();
        TransferTable {
            rows,
            ..TransferTable::new(domain, reference_mm, entries)
        }
    }

    /// The rows of a function of value and gradient magnitude, as many columns as [`entries`](Self::entries); none of one of the value alone.
    pub fn rows(&self) -> &[[f32; 4]] {
        &self.rows
    }

    /// Values of the first and the last entry.
    pub fn domain(&self) -> [f32; 2] {
        self.domain
    }

    /// The length in mm that an entry's opacity belongs to.
    pub fn reference_mm(&self) -> f32 {
        self.reference_mm
    }

    /// Linear RGB, not premultiplied, and opacity per reference length.
    pub fn entries(&self) -> &[[f32; 4]] {
        &self.entries
    }

    /// Color and opacity at `value`, the defining form: index (value − d0)·(n − 1)/(d1 − d0),
    /// clamped, linear between entries. NaN gives transparent black.
    pub fn at(&self, value: f32) -> [f32; 4] {
        if value.is_nan() {
            return [0.0; 4];
        }
        let last = (self.entries.len() - 1) as f32;
        let [lo, hi] = self.domain;
        let position = ((value - lo) * (last / (hi - lo))).clamp(0.0, last);
        let index = (position as usize).min(self.entries.len() - 2);
        let part = position - index as f32;
        let (a, b) = (self.entries[index], self.entries[index + 1]);
        std::array::from_fn(|c| a[c] + (b[c] - a[c]) * part)
    }

    /// Where its entries lie.
    pub(crate) fn places(&self) -> Places {
        let [lo, hi] = self.domain;
        Places {
            number: self.entries.len(),
            lo,
            per_value: (self.entries.len() - 1) as f32 / (hi - lo),
        }
    }

    /// The largest opacity of any value in `lo..=hi`, exact: the basis of skipping. (Linear pieces
    /// have their maxima at entries or at the ends of the interval.)
    pub fn max_opacity(&self, lo: f32, hi: f32) -> f32 {
        self.entries[self.places().beside(lo, hi)]
            .iter()
            .fold(0.0, |most, e| most.max(e[3]))
    }
}

/// Where the entries of a table lie.
pub(crate) struct Places {
    number: usize,
    lo: f32,
    per_value: f32,
}

impl Places {
    /// The entries that any value from `lo` to `hi` lies beside; one at least.
    pub fn beside(&self, lo: f32, hi: f32) -> Range<usize> {
        let last = (self.number - 1) as f32;
        let position = |value: f32| ((value - self.lo) * self.per_value).clamp(0.0, last);
        // One entry more on either side makes up for rounding in `position`.
        let first = (position(lo) as usize).saturating_sub(1);
        first..(position(hi) as usize + 3).min(self.number)
    }
}
