//! Text for people: on stdout what was asked for, on stderr what went wrong.

use std::io::{self, Write};

/// Writes to stdout. A reader that went away (`strahl info x | head`) ends the program quietly.
pub fn out(text: &str) -> anyhow::Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
    {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => std::process::exit(0),
        other => Ok(other?),
    }
}

/// Something worth knowing that is no failure, on stderr.
pub fn note(text: &str, quiet: bool) {
    if !quiet {
        eprintln!("note: {text}");
    }
}

/// An error and its causes in one line, without what a cause only repeats.
pub fn chain(error: &anyhow::Error) -> String {
    let mut message = String::new();
    for cause in error.chain() {
        let text = cause.to_string();
        if message.contains(&text) {
            continue;
        }
        if !message.is_empty() {
            message.push_str(": ");
        }
        message.push_str(&text);
    }
    message
}

/// A number as people write it: whole numbers with thousands apart, others with up to six digits.
pub fn number(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e15 {
        return thousands(value);
    }
    let digits = (5.0 - value.abs().log10().floor()).clamp(0.0, 15.0) as usize;
    let text = format!("{value:.digits$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

fn thousands(whole: f64) -> String {
    let digits = format!("{:.0}", whole.abs());
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i) % 3 == 0 {
            text.push(',');
        }
        text.push(digit);
    }
    if whole < 0.0 {
        format!("-{text}")
    } else {
        text
    }
}

/// A number of bytes in the largest unit that leaves at least 1.
pub fn bytes(count: u64) -> String {
    let mut size = count as f64;
    for unit in ["bytes", "KiB", "MiB", "GiB"] {
        if size < 1024.0 {
            return match unit {
                "bytes" => format!("{size} bytes"),
                _ => format!("{size:.1} {unit}"),
            };
        }
        size /= 1024.0;
    }
    format!("{size:.1} TiB")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        for (value, text) in [
            (0.0, "0"),
            (-1024.0, "-1,024"),
            (16_777_216.0, "16,777,216"),
            (0.412_345_67, "0.412346"),
            (1.5, "1.5"),
            (-97.126_953_1, "-97.127"),
            (123_456.789, "123457"),
            (1e-7, "0.0000001"),
        ] {
            assert_eq!(number(value), text);
        }
        assert_eq!(bytes(17), "17 bytes");
        assert_eq!(bytes(3 << 19), "1.5 MiB");
    }

    #[test]
    fn a_cause_is_said_once() {
        let io = || std::io::Error::other("disk on fire");
        let once = anyhow::Error::from(io()).context("a.nii: disk on fire");
        assert_eq!(chain(&once), "a.nii: disk on fire");
        let twice = anyhow::Error::from(io()).context("a.nii");
        assert_eq!(chain(&twice), "a.nii: disk on fire");
    }
}
