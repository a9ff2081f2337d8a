//! Files that a picture contains beside its scene, so that it can be drawn again without them: shader functions,
//! patterns of graphs, textures of graphs. Volumes, labels and meshes are not among them.

use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// A picture is no archive: it contains no more bytes of files than this.
pub(crate) const MOST_CARRIED_BYTES: usize = 4 << 20;

/// Files under the paths by which a scene names them. A path may name a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CarriedFiles(BTreeMap<String, CarriedFile>);

#[derive(Clone, Debug, PartialEq, Eq)]
enum CarriedFile {
    File(Vec<u8>),
    /// Names and contents of its files.
    Folder(BTreeMap<String, Vec<u8>>),
}

impl CarriedFiles {
    /// Whether something is carried for the path.
    pub(crate) fn has(&self, path: &str) -> bool {
        self.0.contains_key(path)
    }

    /// The content of the file with this path.
    pub(crate) fn file(&self, path: &str) -> Option<&[u8]> {
        match self.0.get(path)? {
            CarriedFile::File(bytes) => Some(bytes),
            CarriedFile::Folder(_) => None,
        }
    }

    /// Names and contents of the files in the folder with this path, in the order of the names.
    #[cfg(feature = "graph")]
    pub(crate) fn folder(&self, path: &str) -> Option<&BTreeMap<String, Vec<u8>>> {
        match self.0.get(path)? {
            CarriedFile::Folder(files) => Some(files),
            CarriedFile::File(_) => None,
        }
    }

    /// Adds a file, unless that would be too many bytes.
    pub(crate) fn add_file(&mut self, path: &str, bytes: &[u8]) {
        if self.has_space_for(bytes.len()) {
            let file = CarriedFile::File(bytes.to_vec());
            self.0.insert(path.to_owned(), file);
        }
    }

    /// Adds a folder, unless that would be too many bytes.
    pub(crate) fn add_folder(&mut self, path: &str, files: &BTreeMap<String, Vec<u8>>) {
        if self.has_space_for(files.values().map(Vec::len).sum()) {
            let folder = CarriedFile::Folder(files.clone());
            self.0.insert(path.to_owned(), folder);
        }
    }

    fn has_space_for(&self, bytes: usize) -> bool {
        self.bytes().saturating_add(bytes) <= MOST_CARRIED_BYTES
    }

    fn bytes(&self) -> usize {
        let of_file = |file: &CarriedFile| match file {
            CarriedFile::File(bytes) => bytes.len(),
            CarriedFile::Folder(files) => files.values().map(Vec::len).sum(),
        };
        self.0.values().map(of_file).sum()
    }

    /// Adds the files of `other`.
    pub(crate) fn extend(&mut self, other: &CarriedFiles) {
        for (path, file) in &other.0 {
            match file {
                CarriedFile::File(bytes) => self.add_file(path, bytes),
                CarriedFile::Folder(files) => self.add_folder(path, files),
            }
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The same files under other paths.
    pub(crate) fn with_paths(&self, change: impl Fn(&mut String)) -> CarriedFiles {
        let files = self.0.iter().map(|(path, file)| {
            let mut path = path.clone();
            change(&mut path);
            (path, file.clone())
        });
        CarriedFiles(files.collect())
    }

    /// As JSON: a text or `{ "hex": … }` for a file, `{ "folder": … }` for a folder.
    pub(super) fn to_json(&self) -> Value {
        let files = self.0.iter().map(|(path, file)| {
            let value = match file {
                CarriedFile::File(bytes) => json_of(bytes),
                CarriedFile::Folder(files) => {
                    let files = files.iter();
                    let files: Map<_, _> = files.map(|(n, b)| (n.clone(), json_of(b))).collect();
                    json!({ "folder": files })
                }
            };
            (path.clone(), value)
        });
        Value::Object(files.collect())
    }

    /// From JSON. Entries that are neither file nor folder are left out.
    pub(super) fn from_json(value: &Value) -> CarriedFiles {
        let mut carried = CarriedFiles::default();
        for (path, value) in value.as_object().into_iter().flatten() {
            if let Some(bytes) = bytes_of(value) {
                carried.add_file(path, &bytes);
            } else if let Some(files) = value["folder"].as_object() {
                let files = files.iter();
                let files = files.filter_map(|(name, file)| Some((name.clone(), bytes_of(file)?)));
                carried.add_folder(path, &files.collect());
            }
        }
        carried
    }
}

fn json_of(bytes: &[u8]) -> Value {
    match std::str::from_utf8(bytes) {
        Ok(text) => Value::from(text),
        Err(_) => {
            let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
            json!({ "hex": digits })
        }
    }
}

fn bytes_of(value: &Value) -> Option<Vec<u8>> {
    if let Value::String(text) = value {
        return Some(text.clone().into_bytes());
    }
    let pairs = value["hex"].as_str()?.as_bytes().chunks(2);
    let byte = |pair: &[u8]| {
        let digit = |c: u8| char::from(c).to_digit(16);
        let [high, low] = pair else { return None };
        Some((16 * digit(*high)? + digit(*low)?) as u8)
    };
    pairs.map(byte).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_come_back_from_json() {
        let mut carried = CarriedFiles::default();
        carried.add_file("a.wgsl", b"fn a() {}");
        carried.add_file("map.png", &[0x89, b'P', 0, 255]);
        let inside = [("b.wgsl".to_owned(), b"fn b() {}".to_vec())].into();
        carried.add_folder("pats", &inside);
        assert_eq!(CarriedFiles::from_json(&carried.to_json()), carried);
        assert_eq!(carried.folder("pats"), Some(&inside));
        assert_eq!(carried.file("pats"), None);
        let moved = carried.with_paths(|path| path.insert_str(0, "x/"));
        assert_eq!(moved.file("x/map.png"), carried.file("map.png"));
        for damaged in [
            r#"{ "a": 7 }"#,
            r#"{ "a": { "hex": "4" } }"#,
            r#"{ "a": { "hex": "é4" } }"#,
            r#"{ "a": { "folder": "b" } }"#,
            "7",
        ] {
            let value = serde_json::from_str(damaged).unwrap();
            assert!(CarriedFiles::from_json(&value).is_empty(), "{damaged}");
        }
    }

    #[test]
    fn large_files_are_left_out() {
        let mut carried = CarriedFiles::default();
        carried.add_file("large", &vec![0; MOST_CARRIED_BYTES + 1]);
        assert!(carried.is_empty());
    }
}
