//! What one access to the volume memory costs.

/// What an access found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Access {
    /// Clocks that the pipeline is held for rows.
    pub row_clocks: u32,
    /// Clocks that it is held for a refresh.
    pub refresh_clocks: u32,
    /// Clocks that it is held because one module cannot deliver eight words at once, or because of bursts.
    pub serial_clocks: u32,
    /// Clocks that the distance store holds it beyond these.
    pub distance_clocks: u32,
    /// Rows of the distance store opened.
    pub distance_misses: u32,
    /// Rows opened, over all modules.
    pub module_misses: u32,
    /// Whether the document's counter sees a change.
    pub thesis_changes: u32,
}

impl Access {
    /// Clocks that the pipeline is held.
    #[inline(always)]
    pub fn clocks(&self) -> u32 {
        self.row_clocks + self.refresh_clocks + self.serial_clocks + self.distance_clocks
    }
}
