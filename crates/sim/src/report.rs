//! A report: text, tables, charts and pictures, as one HTML file that needs nothing else, and as single files.

use crate::Error;
use crate::chart::{Chart, escape};
use std::fmt::Write;
use std::path::Path;

/// What a study or a run has to show.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Short name, for files.
    pub name: String,
    /// Its heading.
    pub title: String,
    /// Paragraphs.
    pub text: Vec<String>,
    /// Tables.
    pub tables: Vec<Table>,
    /// Charts: name for the file, and the chart.
    pub charts: Vec<(String, Chart)>,
    /// Pictures: name for the file, caption, PNG.
    pub pictures: Vec<(String, String, Vec<u8>)>,
    /// Drawings: name for the file, and SVG.
    pub drawings: Vec<(String, String)>,
}

/// A table.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Short name, for the file.
    pub name: String,
    /// Names of the columns, with units.
    pub columns: Vec<String>,
    /// The cells.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table with these columns.
    pub fn new(name: &str, columns: &[&str]) -> Table {
        Table {
            name: name.to_owned(),
            columns: columns.iter().map(|c| (*c).to_owned()).collect(),
            rows: Vec::new(),
        }
    }

    /// As CSV.
    pub fn to_csv(&self) -> String {
        let line = |cells: &[String]| {
            let quoted: Vec<String> = cells
                .iter()
                .map(|cell| match cell.contains([',', '"', '\n']) {
                    true => format!("\"{}\"", cell.replace('"', "\"\"")),
                    false => cell.clone(),
                })
                .collect();
            quoted.join(",") + "\n"
        };
        let mut text = line(&self.columns);
        for row in &self.rows {
            text.push_str(&line(row));
        }
        text
    }

    /// As JSON: an array of objects.
    pub fn to_json(&self) -> serde_json::Value {
        let rows = self.rows.iter().map(|row| {
            let cells = self.columns.iter().zip(row).map(|(name, cell)| {
                let value = match cell.parse::<f64>() {
                    Ok(number) if number.is_finite() => serde_json::json!(number),
                    _ => serde_json::json!(cell),
                };
                (name.clone(), value)
            });
            serde_json::Value::Object(cells.collect())
        });
        serde_json::Value::Array(rows.collect())
    }
}

impl Report {
    /// Everything as one HTML file.
    pub fn to_html(&self) -> String {
        html(std::slice::from_ref(self))
    }

    /// Writes CSV, SVG and PNG files of this report, their names beginning with its own, and `NAME.json` with all tables.
    ///
    /// # Errors
    /// The file that cannot be written.
    pub fn write_parts(&self, folder: &Path) -> Result<(), Error> {
        let write = |name: String, bytes: &[u8]| {
            let path = folder.join(name);
            std::fs::write(&path, bytes).map_err(|source| Error::Write {
                path: path.display().to_string(),
                source,
            })
        };
        let mut all = serde_json::Map::new();
        for table in &self.tables {
            write(
                format!("{}-{}.csv", self.name, table.name),
                table.to_csv().as_bytes(),
            )?;
            all.insert(table.name.clone(), table.to_json());
        }
        let json = serde_json::to_string_pretty(&all).unwrap_or_default() + "\n";
        write(format!("{}.json", self.name), json.as_bytes())?;
        for (name, chart) in &self.charts {
            write(
                format!("{}-{name}.svg", self.name),
                chart.to_svg().as_bytes(),
            )?;
        }
        for (name, svg) in &self.drawings {
            write(format!("{}-{name}.svg", self.name), svg.as_bytes())?;
        }
        for (name, _, png) in &self.pictures {
            write(format!("{}-{name}.png", self.name), png)?;
        }
        Ok(())
    }
}

/// Several reports as one HTML file.
pub fn html(reports: &[Report]) -> String {
    let title = match reports {
        [one] => escape(&one.title),
        _ => "The pipeline processor: studies".to_owned(),
    };
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title>\n<style>\n\
         body{{font:15px/1.5 sans-serif;max-width:1000px;margin:2em auto;padding:0 1em;color:#222}}\n\
         table{{border-collapse:collapse;margin:1em 0;font-size:13px}}td,th{{border:1px solid #ccc;padding:3px 8px;text-align:right}}\n\
         td:first-child,th:first-child{{text-align:left}}th{{background:#f3f3f3}}figure{{display:inline-block;margin:.5em 1em .5em 0}}\n\
         figure img{{image-rendering:pixelated;min-width:256px;max-width:100%;background:#000}}figcaption{{font-size:13px;color:#555}}\n\
         .drawing{{overflow-x:auto}}\n</style></head><body>\n"
    );
    if reports.len() > 1 {
        let _ = writeln!(text, "<h1>{title}</h1>\n<ul>");
        for report in reports {
            let _ = writeln!(
                text,
                "<li><a href=\"#{}\">{}</a></li>",
                report.name,
                escape(&report.title)
            );
        }
        text.push_str("</ul>\n");
    }
    for report in reports {
        let _ = writeln!(
            text,
            "<h2 id=\"{}\">{}</h2>",
            report.name,
            escape(&report.title)
        );
        for paragraph in &report.text {
            let _ = writeln!(text, "<p>{}</p>", escape(paragraph));
        }
        for (name, caption, png) in &report.pictures {
            let _ = writeln!(
                text,
                "<figure><img alt=\"{name}\" src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>",
                base64(png),
                escape(caption)
            );
        }
        for (_, chart) in &report.charts {
            text.push_str(&chart.to_svg());
        }
        for (_, svg) in &report.drawings {
            let _ = writeln!(text, "<div class=\"drawing\">{svg}</div>");
        }
        for table in &report.tables {
            text.push_str("<table><tr>");
            for column in &table.columns {
                let _ = write!(text, "<th>{}</th>", escape(column));
            }
            text.push_str("</tr>\n");
            for row in &table.rows {
                text.push_str("<tr>");
                for cell in row {
                    let _ = write!(text, "<td>{}</td>", escape(cell));
                }
                text.push_str("</tr>\n");
            }
            text.push_str("</table>\n");
        }
    }
    text.push_str("</body></html>\n");
    text
}

/// RFC 4648, with padding.
fn base64(bytes: &[u8]) -> String {
    const SET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let word =
            chunk.iter().fold(0u32, |w, b| w << 8 | u32::from(*b)) << (8 * (3 - chunk.len()));
        for i in 0..4 {
            match i <= chunk.len() {
                true => text.push(char::from(SET[(word >> (18 - 6 * i) & 63) as usize])),
                false => text.push('='),
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_as_in_the_standard() {
        let cases = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foobar", "Zm9vYmFy"),
        ];
        for (text, expected) in cases {
            assert_eq!(base64(text.as_bytes()), expected);
        }
    }

    #[test]
    fn tables_survive_commas() {
        let mut table = Table::new("t", &["a", "b"]);
        table
            .rows
            .push(vec!["x, \"y\"".to_owned(), "1.5".to_owned()]);
        assert_eq!(table.to_csv(), "a,b\n\"x, \"\"y\"\"\",1.5\n");
        assert_eq!(table.to_json()[0]["b"], 1.5);
    }
}
