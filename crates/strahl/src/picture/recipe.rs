//! What a picture file says about how it was made.

/// This program and its version, as picture files name it.
pub const SOFTWARE: &str = concat!("Strahl ", env!("CARGO_PKG_VERSION"));

/// What a picture file says about how it was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recipe {
    /// The scene as JSON.
    pub scene: String,
    /// The program and its version, such as `Strahl 0.1.0`.
    pub software: String,
}

impl Recipe {
    /// A scene, made into a picture by this version.
    pub fn new(scene: impl Into<String>) -> Recipe {
        Recipe {
            scene: scene.into(),
            software: SOFTWARE.into(),
        }
    }
}
