//! What a picture file says about how it was made.

use super::CarriedFiles;
use serde_json::{Value, json};
use strahl_scene::{MOST_SCENE_BYTES, Scene};

/// This program and its version, as picture files name it.
pub const SOFTWARE: &str = concat!("Strahl ", env!("CARGO_PKG_VERSION"));

/// What a picture file says about how it was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recipe {
    /// The scene as JSON, with every default filled in. The last line may be a comment: the scene without
    /// defaults, and files that it names.
    pub scene: String,
    /// The program and its version, such as `Strahl 0.1.0`.
    pub software: String,
}

/// What the scene of a picture was made from, for drawing it again with other settings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MadeFrom {
    /// The scene as it was given, without defaults. Its graph is in the scene with defaults only.
    pub given: Scene,
    /// Files that the scene names.
    pub files: CarriedFiles,
}

/// How the comment begins.
const MADE_FROM: &str = "// made from ";

impl Recipe {
    /// A scene, made into a picture by this version.
    pub fn new(scene: impl Into<String>) -> Recipe {
        Recipe {
            scene: scene.into(),
            software: SOFTWARE.into(),
        }
    }

    /// The same with what the scene was made from. Files that would make the text longer than a scene may be are left
    /// out.
    pub fn with_made_from(mut self, made_from: &MadeFrom) -> Recipe {
        // JSON in one line: line breaks in texts are escaped.
        let given: Value = serde_json::from_str(&made_from.given.to_json()).unwrap_or_default();
        for files in [&made_from.files, &CarriedFiles::default()] {
            let all = json!({ "given": given, "files": files.to_json() }).to_string();
            if self.scene.len() + MADE_FROM.len() + all.len() + 2 <= MOST_SCENE_BYTES {
                self.scene = format!("{}\n{MADE_FROM}{all}\n", self.scene.trim_end());
                break;
            }
        }
        self
    }

    /// What the scene was made from; `None` for pictures of older versions.
    pub fn made_from(&self) -> Option<MadeFrom> {
        let last = self.scene.trim_end().lines().next_back()?;
        let all: Value = serde_json::from_str(last.strip_prefix(MADE_FROM)?).ok()?;
        let given = all.get("given")?.to_string();
        Some(MadeFrom {
            given: Scene::parse("picture", &given).ok()?,
            files: CarriedFiles::from_json(&all["files"]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_of_a_scene_come_back() {
        let given = Scene::parse(
            "given",
            r#"{ "preset": "mr", "functions": { "classify": { "module": "a\nb.wgsl" } } }"#,
        );
        let mut made_from = MadeFrom {
            given: given.unwrap(),
            files: CarriedFiles::default(),
        };
        made_from
            .files
            .add_file("a\nb.wgsl", b"// text\nfn classify() {}");
        let plain = Recipe::new(Scene::default().to_json());
        assert_eq!(plain.made_from(), None);
        let recipe = plain.with_made_from(&made_from);
        assert_eq!(recipe.made_from(), Some(made_from));
        // It is still the scene.
        assert_eq!(
            Scene::parse("scene", &recipe.scene).unwrap(),
            Scene::default()
        );
        for damaged in [
            "{}\n// made from {",
            "{}\n// made from {}",
            "// made from 7",
            "",
        ] {
            assert_eq!(Recipe::new(damaged).made_from(), None, "{damaged}");
        }
    }
}
