//! Text for people: on stdout what was asked for, on stderr what went wrong.

use std::borrow::Cow;
use std::io::{self, IsTerminal, Write};

/// Writes to stdout. A reader that went away (`strahl info x | head`) ends the program quietly. What goes to a
/// terminal is [`harmless`].
pub fn out(text: &str) -> anyhow::Result<()> {
    let mut stdout = io::stdout().lock();
    let text = match stdout.is_terminal() {
        true => harmless(text),
        false => text.into(),
    };
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
        message(&format!("note: {text}"));
    }
}

/// Writes a line to stderr, [`harmless`]. What nobody can be told, because stderr is full or closed, is no reason to
/// end.
pub fn message(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", harmless(text));
}

/// Text that may have come out of a file, with everything but letters, signs and ends of lines escaped: bytes that
/// command a terminal, and marks that turn the direction of writing.
pub fn harmless(text: &str) -> Cow<'_, str> {
    let commands = |c: char| {
        let is_mark = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        is_mark || c.is_control() && !matches!(c, '\n' | '\t')
    };
    if !text.contains(commands) {
        return text.into();
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match commands(c) {
            true => out.extend(c.escape_default()),
            false => out.push(c),
        }
    }
    out.into()
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
    if value.is_finite() && value.abs() >= 1e15 {
        return format!("{value:.5e}");
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
    fn what_commands_a_terminal_is_escaped() {
        assert_eq!(harmless("Schädel\n\t头"), "Schädel\n\t头");
        assert_eq!(
            harmless("\x1b]0;x\x07\u{9b}31m\r\u{202e}gpj"),
            r"\u{1b}]0;x\u{7}\u{9b}31m\r\u{202e}gpj"
        );
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
