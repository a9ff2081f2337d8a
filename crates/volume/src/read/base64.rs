//! Bytes written as text (RFC 4648), as VTK's XML files have them.

use crate::error::{Error, ErrorKind};

/// Decodes text up to its end or the padding; white space means nothing. Returns the bytes and the rest of the text.
///
/// # Errors
/// A letter that does not belong to it.
pub(crate) fn decoded(text: &[u8]) -> Result<(Vec<u8>, &[u8]), Error> {
    let mut bytes = Vec::new();
    let (mut held, mut bits) = (0u32, 0);
    for (at, &letter) in text.iter().enumerate() {
        let value = match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            b'=' => {
                let rest = &text[at..];
                let padding = rest
                    .iter()
                    .take_while(|c| **c == b'=' || c.is_ascii_whitespace());
                return Ok((bytes, &rest[padding.count()..]));
            }
            _ if letter.is_ascii_whitespace() => continue,
            _ => {
                return Err(ErrorKind::Compression {
                    codec: "base64",
                    why: format!("`{}` is no letter of it", letter.escape_ascii()),
                }
                .into());
            }
        };
        held = (held << 6 | u32::from(value)) & 0xFFFF;
        bits += 6;
        if bits >= 8 {
            bits -= 8;
            bytes.push((held >> bits) as u8);
        }
    }
    Ok((bytes, &[]))
}

#[cfg(test)]
mod tests {
    use super::decoded;

    #[test]
    fn vectors_of_the_standard() {
        for (text, bytes) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9v\nYmFy", "foobar"),
        ] {
            assert_eq!(decoded(text.as_bytes()).unwrap().0, bytes.as_bytes());
        }
        let (head, rest) = decoded(b"Zg==Zm8=").unwrap();
        assert_eq!((&head[..], rest), (&b"f"[..], &b"Zm8="[..]));
        assert!(decoded(b"Zm9v?").is_err());
    }
}
