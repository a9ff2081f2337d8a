//! Volumes whose stored numbers are their values.

use crate::{ContentId, Control, Error, Key, Metadata, Rescale, Samples, Volume, memory};

impl Volume {
    /// The values as stored numbers of f32 on the same grid, under `control`: what grows with the values where the
    /// stored numbers do not.
    ///
    /// # Errors
    /// It was cancelled; no memory.
    pub fn values_under(&self, control: &Control) -> Result<Volume, Error> {
        // After so many somebody looks at the control.
        const PIECE: usize = 1 << 16;
        let number = self.grid().voxel_count();
        let mut values = memory::reserved(number)?;
        for start in (0..number).step_by(PIECE) {
            control.check()?;
            let value = |i| self.rescale().value(self.samples().get(i)) as f32;
            values.extend((start..number.min(start + PIECE)).map(value));
        }
        let (values, metadata) = (Samples::F32(values), Metadata::default());
        Volume::new(*self.grid(), values, Rescale::IDENTITY, metadata)
    }
}

/// Key of the [values](Volume::values_under) of a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct ValuesKey(pub ContentId);

impl Key for ValuesKey {
    type Value = Volume;

    const NAME: &str = "values of masks";

    fn bytes(&self, value: &Volume) -> usize {
        value.samples().as_bytes().len()
    }
}
