use crate::lanes::Vec3s;
use crate::levels::Level;

/// What a sample's shading may ask for.
pub struct Place<S: Level, G, P> {
    /// The gradient; called only if it matters.
    pub gradient: G,
    /// Where the sample is in the world; called only if it matters.
    pub place_mm: P,
    /// Unit vector.
    pub to_eye: Vec3s<S>,
}
