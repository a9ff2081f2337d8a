//! Text in the character sets of DICOM (PS3.3, C.12.1.1.2).

use encoding_rs::Encoding;

/// The text of `bytes`; `sets` is SpecificCharacterSet (0008,0005), whose first name that is not empty counts. Without
/// a name that is known it is ISO 8859-1, of which the default of the standard is a part.
pub(super) fn decoded(sets: &str, bytes: &[u8]) -> String {
    let set = sets.split('\\').map(str::trim).find(|set| !set.is_empty());
    match set.and_then(encoding) {
        Some(encoding) => encoding.decode_without_bom_handling(bytes).0.into_owned(),
        None => bytes.iter().map(|byte| char::from(*byte)).collect(),
    }
}

/// The encoding that a defined term stands for; none for ISO 8859-1 and for terms that are not known.
fn encoding(term: &str) -> Option<&'static Encoding> {
    let number = ["ISO 2022 IR ", "ISO_IR ", "ISO_IR_"]
        .iter()
        .find_map(|prefix| term.strip_prefix(prefix));
    Some(match number.unwrap_or(term) {
        "13" => encoding_rs::SHIFT_JIS,
        "58" | "GBK" | "GB2312" => encoding_rs::GBK,
        "87" => encoding_rs::ISO_2022_JP,
        "101" => encoding_rs::ISO_8859_2,
        "109" => encoding_rs::ISO_8859_3,
        "110" => encoding_rs::ISO_8859_4,
        "126" => encoding_rs::ISO_8859_7,
        "127" => encoding_rs::ISO_8859_6,
        "138" => encoding_rs::ISO_8859_8,
        "144" => encoding_rs::ISO_8859_5,
        "149" => encoding_rs::EUC_KR,
        "166" => encoding_rs::WINDOWS_874,
        "192" => encoding_rs::UTF_8,
        "GB18030" => encoding_rs::GB18030,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_read_in_the_set_that_is_named() {
        let utf8 = "王^小".as_bytes();
        for (sets, bytes, text) in [
            ("", &b"M\xfcller"[..], "Müller"),
            ("ISO_IR 100", b"Buc^J\xe9r\xf4me", "Buc^Jérôme"),
            ("\\ISO 2022 IR 126", b"\xc4\xe9\xef\xed", "Διον"),
            ("ISO_IR 144", b"\xbb\xee\xda", "Люк"),
            ("ISO_IR 192", utf8, "王^小"),
            ("GB18030", b"\xcd\xf5", "王"),
            ("ISO 2022 IR 87", b"\x1b$B;3ED\x1b(B", "山田"),
            ("ISO_IR 13", b"\xd4\xcf\xc0\xde", "ﾔﾏﾀﾞ"),
            ("ISO_IR 166", b"\xa1", "ก"),
            ("no such set", b"\xe9", "é"),
        ] {
            assert_eq!(decoded(sets, bytes), text, "{sets}");
        }
    }
}
