//! Tables of the names and colors of labels: inside of images, and in files of their own.
//!
//! | format          | example                                              | written by                 |
//! |-----------------|------------------------------------------------------|----------------------------|
//! | JSON            | `{ "R": […], "G": […], "B": […], "labels": […] }`    | niivue                     |
//! | JSON            | `{ "5": { "name": "liver", "color": "#dd8265" } }`   | by hand                    |
//! | JSON            | `{ "labels": { "background": 0, "liver": 1 } }`      | nnU-Net                    |
//! | color table     | `5 liver 221 130 101 255`                            | FreeSurfer, 3D Slicer      |
//! | label descriptions | `5 221 130 101 1 1 1 "liver"`                     | ITK-SNAP                   |
//! | CSV, TSV        | `id,name,color` and `5,liver,#dd8265`                | by hand, BIDS              |
//! | lines           | `5 liver`                                            | comments of NIfTI files    |
//! | XML             | `<Label Key="5" Red="0.87" …>liver</Label>`          | Workbench, TotalSegmentator |

pub(crate) mod caret;
mod color_table;
mod delimited;
mod itk_snap;
mod json;
pub(crate) mod lines;
mod table;

use super::{Files, LoadedVolume};
use crate::{Error, Label};

/// Tables have a line for each label; a longer file is something else.
const MOST_BYTES: u64 = 1 << 24;

/// Reads a table of names and colors from the bytes of the file `name`. The format is found from
/// the content:
///
/// - JSON: niivue's arrays `R`, `G`, `B` and `labels`; an object of ids, each with a name or with
///   `name`, `color` and `group`; an object of names with ids, also as `labels` of nnU-Net's
///   `dataset.json`
/// - color tables of FreeSurfer and 3D Slicer (`id name r g b a`, 0 to 255)
/// - label descriptions of ITK-SNAP (`id r g b a visible mesh "name"`)
/// - CSV and TSV with a header: `id` and `name`, optionally `color` or `r`, `g`, `b`, and `group`
/// - lines `id name`
/// - the XML of Caret and Connectome Workbench
///
/// Colors of `color`, `r`, `g` and `b` are `#rrggbb`, or numbers from 0 to 255, or from 0 to 1 if no
/// number in the table is larger than 1. Alpha is ignored.
///
/// ```
/// use strahl_volume::read::read_label_table;
/// let labels = read_label_table("organs.csv", b"id,name,color\n5,liver,#ff0080\n")?;
/// assert_eq!((labels[0].id, labels[0].name.as_str()), (5, "liver"));
/// assert_eq!(labels[0].color, Some([1.0, 0.0, 128.0 / 255.0]));
/// # Ok::<(), strahl_volume::Error>(())
/// ```
///
/// # Errors
/// Another format; an id or color that is not one; an id that occurs twice. The message names the
/// line, or the key of JSON.
pub fn read_label_table(name: &str, bytes: &[u8]) -> Result<Vec<Label>, Error> {
    let unknown = || {
        let allowed = "JSON, CSV with a header, lines that begin with an id, or Caret's XML";
        Error::field("the label table", "of no known format", allowed)
    };
    let read = recognized(&text_of(bytes)).and_then(|labels| labels.ok_or_else(unknown));
    read.map_err(|error| error.in_file(name))
}

/// The labels in a text, if it is a label table.
fn recognized(text: &str) -> Result<Option<Vec<Label>>, Error> {
    Ok(match () {
        () if text.trim_start().starts_with('{') => json::read(text)?,
        () if caret::looks_like(text) => Some(caret::read(text, 0)?),
        () if itk_snap::looks_like(text) => Some(itk_snap::read(text)?),
        () if delimited::looks_like(text) => Some(delimited::read(text)?),
        () if color_table::looks_like(text) => Some(color_table::read(text)?),
        () if lines::looks_like(text) => Some(lines::read(text)?),
        () => None,
    })
}

fn text_of(bytes: &[u8]) -> String {
    let text = bytes.strip_prefix(super::header_lines::BYTE_ORDER_MARK);
    String::from_utf8_lossy(text.unwrap_or(bytes)).into_owned()
}

/// Gives labels that were read from the file `name` the names and colors of a table beside it, if
/// there is one: `organs.json` beside `organs.nii.gz`, or nnU-Net's `dataset.json` for a file that
/// names nothing itself.
pub(crate) fn add_beside(
    loaded: &mut LoadedVolume,
    name: &str,
    files: &dyn Files,
) -> Result<(), Error> {
    const ENDINGS: [&str; 7] = ["json", "csv", "tsv", "txt", "ctbl", "label", "lut"];
    let labels = loaded.labels.get_or_insert_default();
    let stem = stem_of(name);
    let stems = [Some(stem), stem.strip_suffix(".seg")];
    let of_stem = |stem: &str| ENDINGS.map(|ending| format!("{stem}.{ending}"));
    let mut candidates: Vec<String> = stems.into_iter().flatten().flat_map(of_stem).collect();
    if labels.is_empty() {
        candidates.push("dataset.json".into());
    }
    for table in candidates.iter().filter(|table| *table != name) {
        // Opened without being listed: whoever keeps in mind what was looked for, sees a new table.
        let Ok(file) = files.open(table) else {
            continue;
        };
        if file.len() > MOST_BYTES {
            continue;
        }
        let mut bytes = vec![0; file.len() as usize];
        let read = file.read_at(0, &mut bytes);
        read.map_err(|error| Error::from(error).in_file(table))?;
        match recognized(&text_of(&bytes)) {
            Ok(None) => {}
            Ok(Some(found)) => {
                let note = format!("names and colors of labels are those of {table}");
                loaded.notes.push(note);
                *labels = found;
                return Ok(());
            }
            Err(error) => {
                let note = format!("names and colors of labels in {table} are not used: {error}");
                loaded.notes.push(note);
            }
        }
    }
    Ok(())
}

/// The name of an image without its ending.
pub fn stem_of(name: &str) -> &str {
    let lower = name.to_ascii_lowercase();
    let packed = [".gz", ".bz2"].iter().find(|end| lower.ends_with(*end));
    let unpacked = &name[..name.len() - packed.map_or(0, |end| end.len())];
    match unpacked.rfind('.') {
        Some(0) | None => unpacked,
        Some(dot) => &unpacked[..dot],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: &[(u32, &str, Option<[u8; 3]>)]) {
        let read = read_label_table("table", text.as_bytes()).unwrap();
        let label = |&(id, name, color): &(u32, &str, Option<[u8; 3]>)| Label {
            color: color.map(|color| color.map(|c| f32::from(c) / 255.0)),
            ..Label::new(id, name)
        };
        assert_eq!(read, expected.iter().map(label).collect::<Vec<_>>());
    }

    #[track_caller]
    fn refused(text: &str, expected: &str) {
        let message = read_label_table("table", text.as_bytes()).unwrap_err();
        let message = message.to_string();
        assert!(
            message.starts_with(&format!("table: {expected}")),
            "{message}"
        );
    }

    #[test]
    fn formats_are_told_apart_by_their_content() {
        let liver = [(5, "liver", Some([221, 130, 101]))];
        check(
            "{\"5\": {\"name\": \"liver\", \"color\": \"#dd8265\"}}",
            &liver,
        );
        check("\u{feff}# comment\n5 liver 221 130 101 255\n", &liver);
        check("  5  221 130 101   1  1 0  \"liver\"\r\n", &liver);
        check("id;color;name\n5;#DD8265;liver", &liver);
        check("5 liver", &[(5, "liver", None)]);
        check("{\"labels\": {\"liver\": 5}}", &[(5, "liver", None)]);
        check(
            "<LabelTable><Label Key=\"5\">liver</Label></LabelTable>",
            &[(5, "liver", None)],
        );
        for other in [
            "",
            "{}",
            "[]",
            "liver",
            "{\"EchoTime\": 0.03}",
            "a,b\n1,2",
            "\0\x01",
        ] {
            refused(
                other,
                "the label table is of no known format; allowed: JSON, CSV",
            );
        }
    }

    #[test]
    fn color_tables_of_freesurfer_and_slicer() {
        let text = "#No. Label Name:      R   G   B   A\n\n\
            0   Unknown                     0   0   0   0\n\
            2   Left-Cerebral-White-Matter  245 245 245 0\n\
            999 Area 4 a    1   2   3   0\n";
        let expected = [
            (0, "Unknown", Some([0, 0, 0])),
            (2, "Left-Cerebral-White-Matter", Some([245; 3])),
            (999, "Area 4 a", Some([1, 2, 3])),
        ];
        check(text, &expected);
        for (from, to, expected) in [
            (
                "245 0",
                "256 0",
                "line 4: blue is `256`; allowed: a number from 0 to 255",
            ),
            ("245 245 245", "245 x 245", "line 4: green is `x`"),
            ("245 245 245", "-1 245 245", "line 4: red is `-1`"),
            ("245 245 245", "NaN 245 245", "line 4: red is `NaN`"),
            (
                "999 ",
                "2 ",
                "line 5: the id is 2, as in line 4; allowed: each id once",
            ),
            (
                "999 ",
                "x ",
                "line 5: the id is `x`; allowed: a whole number from 0 to 4294967295",
            ),
            ("999 ", "4294967296 ", "line 5: the id is `4294967296`"),
            (
                "Area 4 a    1 ",
                "",
                "line 5 is `999   2   3   0`; allowed: id, name, red",
            ),
        ] {
            refused(&text.replace(from, to), expected);
        }
    }

    #[test]
    fn label_descriptions_of_itk_snap() {
        let text = "################\n# ITK-SnAP Label Description File\n\
            0     0    0    0        0  0  0    \"Clear Label\"\n\
            7   255    0   16        0.5  1  1    \"left \\\"upper\\\" lobe\"\n";
        let expected = [
            (0, "Clear Label", Some([0; 3])),
            (7, "left \\\"upper\\\" lobe", Some([255, 0, 16])),
        ];
        check(text, &expected);
        refused(&text.replace("255", "300"), "line 4: red is `300`");
        refused(
            &text.replace("7  ", "0  "),
            "line 4: the id is 0, as in line 3",
        );
        refused(&text.replace("1  1", "1"), "line 4 is `7   255");
    }

    #[test]
    fn csv_by_the_names_of_its_columns() {
        let bytes = "Index\tr\tg\tb\tName\tabbreviation\n3\t255\t0\t1\ta\tA\n4\t\t\t\tb\tB\n";
        check(bytes, &[(3, "a", Some([255, 0, 1])), (4, "b", None)]);
        // No number above 1: shares.
        let shares = "id,r,g,b,name\n3,1,0,1,\"a, \"\"b\"\"\"\n4,0,1,0,c";
        check(
            shares,
            &[
                (3, "a, \"b\"", Some([255, 0, 255])),
                (4, "c", Some([0, 255, 0])),
            ],
        );
        let read = read_label_table("t", b"id,name,group\n1,a,Tissue\n2,b,\n").unwrap();
        assert_eq!(read[0].group.as_deref(), Some("Tissue"));
        assert_eq!(read[1].group, None);
        for (text, expected) in [
            ("id,name\n1,a\n1,b", "line 3: the id is 1, as in line 2"),
            ("id,name\n1.5,a", "line 2: the id is `1.5`"),
            (
                "id,name,color\n1,a,red",
                "line 2: color is `red`; allowed: such as #dd8265",
            ),
            ("id,r,g,b\n1,0,0,256", "line 2: blue is `256`"),
            ("id,r,g,b\n1,0,,2", "line 2: green is ``"),
            (
                "id,name\n1",
                "line 2: the number of columns is 1; allowed: 2, as in the header",
            ),
            ("id,name\n1,\"a", "line 2: a quoted text is not closed"),
        ] {
            let message = read_label_table("t", text.as_bytes())
                .unwrap_err()
                .to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn json_of_niivue() {
        let text = "{\"R\": [9, 255, 0], \"G\": [9, 0, 128], \"B\": [9, 0, 255], \
            \"A\": [0, 64, 64], \"labels\": [\"\", \"a\", \"b\"]}";
        let (red, blue) = (Some([255, 0, 0]), Some([0, 128, 255]));
        check(text, &[(1, "a", red), (2, "b", blue)]);
        let ids = text.replacen('{', "{\"I\": [0, 300, 7], ", 1);
        check(&ids, &[(300, "a", red), (7, "b", blue)]);
        check(
            "{\"labels\": [\"air\", \"a\"]}",
            &[(0, "air", None), (1, "a", None)],
        );
        for (from, to, expected) in [
            (
                "[9, 255, 0]",
                "[9, 256, 0]",
                "`R[1]` is 256; allowed: 0 to 255",
            ),
            (
                "[9, 255, 0]",
                "[9, 255]",
                "the length of `R` is 2 entries; allowed: 3, as `labels`",
            ),
            (
                "[9, 255, 0]",
                "[9, \"x\", 0]",
                "`R[1]` is \"x\"; allowed: 0 to 255",
            ),
            ("\"a\"", "3", "`labels[1]` is 3; allowed: a name"),
            ("[9, 255, 0]", "7", "`R` is 7; allowed: a list"),
        ] {
            refused(&text.replace(from, to), expected);
        }
        refused(
            &ids.replace("300", "7"),
            "`I[2]`: the id is 7, as in `I[1]`",
        );
    }

    #[test]
    fn json_by_id_and_by_name() {
        check(
            "{\"2\": \"a\", \"1\": {\"name\": \"b\", \"color\": [255, 0, 51]}, \"3\": {}}",
            &[(2, "a", None), (1, "b", Some([255, 0, 51])), (3, "", None)],
        );
        check(
            "{\"1\": {\"name\": \"b\", \"color\": [1, 0, 0.2]}}",
            &[(1, "b", Some([255, 0, 51]))],
        );
        let of_nnu_net = "{\"name\": \"x\", \"channel_names\": {\"0\": \"CT\"}, \
            \"labels\": {\"background\": 0, \"liver\": 2}, \"numTraining\": 7}";
        check(of_nnu_net, &[(0, "background", None), (2, "liver", None)]);
        check(
            "{\"liver\": 2, \"spleen\": 7}",
            &[(2, "liver", None), (7, "spleen", None)],
        );
        for (text, expected) in [
            (
                "{\"1\": \"a\", \"1\": \"b\"}",
                "`1`: the id is 1, as in `1`",
            ),
            ("{\"1\": \"a\", \"x\": \"b\"}", "`x`: the id is `x`"),
            ("{\"1\": 2}", "`1` is 2; allowed: a name, or an object"),
            (
                "{\"1\": {\"nam\": 2}}",
                "`1.nam` is not known; allowed: name, color, group",
            ),
            ("{\"1\": {\"name\": 2}}", "`1.name` is 2; allowed: a text"),
            (
                "{\"1\": {\"color\": [1, 2]}}",
                "`1.color` is a list; allowed: #rrggbb",
            ),
            (
                "{\"1\": {\"color\": [1, 2, 256]}}",
                "`1.color[2]` is 256; allowed: 0 to 255",
            ),
            (
                "{\"labels\": {\"a\": 1, \"b\": 1}}",
                "`labels.b`: the id is 1, as in `labels.a`",
            ),
            (
                "{\"labels\": {\"a\": 0.5}}",
                "`labels.a` is 0.5; allowed: one id",
            ),
            (
                "{\"labels\": {\"a\": [1, 2]}}",
                "`labels.a` is a list; allowed: one id",
            ),
        ] {
            refused(text, expected);
        }
        refused("{\"1\": \"a\",\n\"2\"}", "line 2 is no JSON: expected `:`");
        refused(
            &"{\"1\":".repeat(10_000),
            "line 1 is no JSON: recursion limit",
        );
    }

    #[test]
    fn stems_have_no_endings() {
        for (name, stem) in [
            ("a.b.nii.gz", "a.b"),
            ("liver.NII.GZ", "liver"),
            ("x.seg.nrrd", "x.seg"),
            ("scan", "scan"),
            (".hidden", ".hidden"),
            ("", ""),
        ] {
            assert_eq!(stem_of(name), stem);
        }
    }
}
