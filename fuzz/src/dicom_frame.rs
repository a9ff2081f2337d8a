//! A DICOM file of one packed frame, so that a fuzzer spends its inputs on the decoder and not on the header.

/// Of each decoder the transfer syntaxes that lead to it.
const SYNTAXES: [&str; 9] = [
    "1.2.840.10008.1.2.4.90", // JPEG 2000, lossless
    "1.2.840.10008.1.2.4.91", // JPEG 2000
    "1.2.840.10008.1.2.4.50", // JPEG, 8 bits
    "1.2.840.10008.1.2.4.51", // JPEG, 12 bits
    "1.2.840.10008.1.2.4.57", // JPEG lossless
    "1.2.840.10008.1.2.4.70", // JPEG lossless, first predictor
    "1.2.840.10008.1.2.4.80", // JPEG-LS, lossless
    "1.2.840.10008.1.2.4.81", // JPEG-LS, near-lossless
    "1.2.840.10008.1.2.5",    // RLE
];

/// The file around an input of 5 bytes (syntax, rows, columns, bits per number, and whether it is signed and has
/// three components) and the frame. `None` if there are fewer.
pub fn file_around(input: &[u8]) -> Option<Vec<u8>> {
    let (&[syntax, rows, columns, bits, kind], frame) = input.split_first_chunk()?;
    let syntax = SYNTAXES[usize::from(syntax) % SYNTAXES.len()];
    let stored = u16::from(bits) % 16 + 1;
    let allocated: u16 = if stored > 8 { 16 } else { 8 };
    let is_rgb = kind & 2 == 2;
    let mut file = vec![0; 128];
    file.extend(b"DICM");
    file.extend(element(0x0002, 0x0010, b"UI", syntax.as_bytes()));
    let number = |element_number: u16, number: u16| {
        element(0x0028, element_number, b"US", &number.to_le_bytes())
    };
    let photometric: &[u8] = if is_rgb { b"RGB" } else { b"MONOCHROME2" };
    let mut image = Vec::new();
    image.extend(element(0x0008, 0x0016, b"UI", b"1.2.840.10008.5.1.4.1.1.2"));
    image.extend(element(0x0008, 0x0060, b"CS", b"CT"));
    image.extend(element(0x0018, 0x0050, b"DS", b"1"));
    image.extend(element(0x0020, 0x000E, b"UI", b"1.2"));
    image.extend(element(0x0020, 0x0032, b"DS", b"0\\0\\0"));
    image.extend(element(0x0020, 0x0037, b"DS", b"1\\0\\0\\0\\1\\0"));
    image.extend(number(0x0002, if is_rgb { 3 } else { 1 }));
    image.extend(element(0x0028, 0x0004, b"CS", photometric));
    if is_rgb {
        image.extend(number(0x0006, 0));
    }
    image.extend(number(0x0010, rows.into()));
    image.extend(number(0x0011, columns.into()));
    image.extend(element(0x0028, 0x0030, b"DS", b"1\\1"));
    image.extend(number(0x0100, allocated));
    image.extend(number(0x0101, stored));
    image.extend(number(0x0102, stored - 1));
    image.extend(number(0x0103, u16::from(kind & 1)));
    image.extend([0xE0, 0x7F, 0x10, 0x00, b'O', b'B', 0, 0]);
    image.extend(u32::MAX.to_le_bytes());
    for item in [&[][..], frame] {
        image.extend([0xFE, 0xFF, 0x00, 0xE0]);
        image.extend((item.len() as u32).to_le_bytes());
        image.extend(item);
    }
    image.extend([0xFE, 0xFF, 0xDD, 0xE0, 0, 0, 0, 0]);
    file.extend(image);
    Some(file)
}

/// An element in explicit VR, little endian; its value is padded to an even length.
fn element(group: u16, number: u16, vr: &[u8; 2], value: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    bytes.extend(group.to_le_bytes());
    bytes.extend(number.to_le_bytes());
    bytes.extend(vr);
    bytes.extend(((value.len() + value.len() % 2) as u16).to_le_bytes());
    bytes.extend(value);
    if value.len() % 2 == 1 {
        bytes.push(if vr == b"UI" { 0 } else { b' ' });
    }
    bytes
}
