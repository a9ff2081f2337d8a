//! Which name was meant.

/// The known name that `found` was probably meant to be.
pub(crate) fn nearest<'a>(found: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = found.to_lowercase().replace(['-', ' '], "_");
    known
        .map(|name| {
            let plain = name.replace('-', "_");
            let alike = strsim::jaro_winkler(&wanted, &plain);
            (alike, name)
        })
        .filter(|(alike, _)| *alike > 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}
