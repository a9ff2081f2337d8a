//! Which name was meant.

use std::cmp::Reverse;

/// The known name that `found` was probably meant to be: the most alike one, as a whole or in one of its words.
pub(crate) fn nearest<'a>(found: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    /// Shorter words are alike by chance.
    const LEAST_WORD: usize = 4;
    let wanted = found.to_lowercase().replace(['-', ' '], "_");
    let alike = |name: &str| {
        let plain = name.replace(['-', ' '], "_");
        let whole = strsim::jaro_winkler(&wanted, &plain);
        let words = plain
            .split('_')
            .filter(|word| word.len().min(wanted.len()) >= LEAST_WORD);
        // A word says less than the whole name, unless it is that very word.
        let of_word = |word: &str| 0.95 * strsim::jaro_winkler(&wanted, word);
        words.map(of_word).fold(whole, f64::max)
    };
    known
        .map(|name| (alike(name), name))
        .filter(|(alike, _)| *alike > 0.8)
        // Of names with the same word, the shortest says least else.
        .max_by(|a, b| {
            let by_length = || Reverse(a.1.len()).cmp(&Reverse(b.1.len()));
            a.0.total_cmp(&b.0).then_with(by_length)
        })
        .map(|(_, name)| name)
}
