//! How much memory a text of JSON may become, told before it is parsed: `{}` takes two bytes there, and a thousand as what
//! it stands for.

/// The most objects and lists of a text.
const MOST_GROUPS: usize = 100_000;
/// The most elements of all objects and lists.
const MOST_ELEMENTS: usize = 1_000_000;

/// Checks how many objects, lists and elements `text` has, in which comments have been replaced by blanks.
///
/// # Errors
/// There are more than a scene or a graph can use; in words.
pub fn check_json_size(text: &str) -> Result<(), String> {
    let (mut groups, mut separators) = (0, 0);
    let (mut in_string, mut is_escaped) = (false, false);
    for byte in text.bytes() {
        match byte {
            _ if is_escaped => is_escaped = false,
            b'\\' if in_string => is_escaped = true,
            b'"' => in_string = !in_string,
            b'{' | b'[' if !in_string => groups += 1,
            b',' if !in_string => separators += 1,
            _ => {}
        }
    }
    if groups > MOST_GROUPS {
        return Err(format!(
            "{groups} objects and lists; at most {MOST_GROUPS} can be read"
        ));
    }
    // A group has one element more than separators, if it has any.
    let elements = groups + separators;
    match elements > MOST_ELEMENTS {
        true => Err(format!(
            "about {elements} elements; at most {MOST_ELEMENTS} can be read"
        )),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_lists_and_elements_are_counted_outside_of_strings() {
        let list =
            |element: &str, n: usize| format!("[{}{element}]", format!("{element},").repeat(n - 1));
        assert_eq!(check_json_size(&list("{}", MOST_GROUPS - 1)), Ok(()));
        let found = check_json_size(&list("{}", MOST_GROUPS)).unwrap_err();
        assert!(found.starts_with("100001 objects"), "{found}");
        assert!(check_json_size(&list("[]", MOST_GROUPS)).is_err());
        assert_eq!(check_json_size(&list("7", MOST_ELEMENTS)), Ok(()));
        assert!(check_json_size(&list("7", MOST_ELEMENTS + 1)).is_err());
        let text = format!(r#"{{ "wgsl": "{}" }}"#, r#"\"{[,\\"#.repeat(MOST_ELEMENTS));
        assert_eq!(check_json_size(&text), Ok(()));
    }
}
